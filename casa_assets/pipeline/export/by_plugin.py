"""A form of export that a plug-in writes."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from casa_assets.errors import CasaError, PluginFailure, UnknownId
from casa_assets.model.files import Files
from casa_assets.pipeline.export.certified import certified_asset
from casa_assets.pipeline.export.form import ASSETS, ExportResult, Form
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.library import library as disk
from casa_assets.registry.plugins.exchange import exporters
from casa_assets.registry.plugins.guard import guarded

TRACES = "traces"


def form_of(name: str) -> Form:
    """The form of the exporter of that name. Raises UnknownId."""
    known = exporters()
    if name not in known:
        raise UnknownId("exporter of plug-ins", name, known)
    plugin, exporter = known[name]
    write = guarded(plugin, f"exporter {name}", exporter.write)

    def write_asset(folder: Path, staged: Path) -> ExportResult:
        asset = certified_asset(folder)
        inside = f"{ASSETS}/{asset.id}"
        try:
            files = write(asset)
        except PluginFailure as error:
            disk.write_files(staged / TRACES, Files(entries={f"{asset.id}.txt": error.trace.encode()}))
            return ExportResult(asset.id, message=f"{error}; the trace: {TRACES}/{asset.id}.txt")
        if wrong := [path for path in files if not _is_inside(path)]:
            return ExportResult(asset.id, message=f"plug-in {plugin.plugin.name}: {wrong[0]!r} leaves the folder")
        if not files:
            return ExportResult(asset.id, message=f"plug-in {plugin.plugin.name} wrote no file")
        disk.write_files(staged / inside, Files(entries=dict(sorted(files.items()))))
        facts = {"category": asset.labels.category, "plugin": f"{plugin.plugin.name} {plugin.version}"}
        return ExportResult(asset.id, f"{inside}/{min(files)}", facts)

    about = f"# Assets by {plugin.plugin.name}\n\n{exporter.about}\n\n`{ASSETS}/<id>/`, a folder for each asset.\n"
    return Form(name, {ASSETS: about}, write_asset, _no_scene)


def _is_inside(path: str) -> bool:
    place = PurePosixPath(path)
    return bool(place.parts) and not place.is_absolute() and ".." not in place.parts


def _no_scene(_: SceneRecipe, __: Path, ___: Path) -> ExportResult:
    raise CasaError("exporters of plug-ins write assets, no kitchens")
