"""The page of review for the articulated meshes of a library, and its 3D models, made from the entries alone."""

from __future__ import annotations

from collections.abc import Sequence

from casa_assets.export.gltf import EVERYTHING, asset_glb
from casa_assets.pipeline.articulate.review_page import render_page
from casa_assets.pipeline.articulate.run import outcome_of_entry
from casa_assets.pipeline.library.library import Library, read_asset
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.reports.library.models import PageModels
from casa_assets.pipeline.viewer.model_files import SUFFIX, model_script
from casa_assets.pipeline.viewer.viewer_file import viewer_name, viewer_script

# Folder of the models and the viewer as the page names it; they are made when they are asked for.
MODELS = "models"
_MODELS = PageModels(f"./{MODELS}", f"./{MODELS}/{viewer_name()}")
COMMAND = "casa-assets articulate SOURCES --library {library}"


def articulated_page(library: Library, entries: Sequence[Entry]) -> str:
    """Return the HTML of the page; entries of which no record is left are not on it."""
    found = [outcome for entry in entries if (outcome := outcome_of_entry(library, entry)) is not None]
    return render_page(library, found, COMMAND.format(library=library.root), is_served=True, models=_MODELS)


def script_of(library: Library, entries: Sequence[Entry], name: str) -> bytes:
    """Return a script that the page names: the viewer or the model of an accepted entry; empty where it is neither.

    Args:
        name: of the file in the folder of models.
    Raises:
        OutputError: the asset cannot be read.
    """
    if name == viewer_name():
        return viewer_script()
    entry = next((one for one in entries if one.accepted and f"{one.id}{SUFFIX}" == name), None)
    return (
        b"" if entry is None else model_script(entry.id, asset_glb(read_asset(library.root / entry.path), EVERYTHING))
    )
