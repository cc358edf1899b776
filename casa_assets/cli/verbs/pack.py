"""casa-assets scenes pack: one file of a kitchen that loads by itself on another machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from casa_assets.cli import completion
from casa_assets.cli.options import OUT_HELP, AsJson, Quiet, ScenesFolder, Verbose, more
from casa_assets.cli.output import Output, measures_at

OUT, SCENES = Path("out/packs"), Path("out/scenes")


def pack(
    scene: Annotated[
        str, typer.Argument(help="Id of a scene, such as l_small__coastal.", autocompletion=completion.kitchens)
    ],
    zip_: Annotated[bool, typer.Option("--zip", help="MJCF, USD, scene.json and all that they name.")] = False,
    usdz: Annotated[bool, typer.Option("--usdz", help="The USD and all that it names, as one USDZ.")] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help=more(OUT_HELP, "by default out/packs/<id>.zip or .usdz."))
    ] = None,
    scenes_folder: ScenesFolder = SCENES,
    json_: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Write a kitchen as one file that loads by itself on another machine; built first where it is missing.

    Exit 0 when it is written, 2 on misuse.

    Example:  casa-assets scenes pack l_small__coastal --zip
    """
    from casa_assets.pipeline.kitchens.pack import PackKind, pack_scene

    if zip_ == usdz:
        raise typer.BadParameter("give one of --zip and --usdz")
    output, kind = Output(json_, quiet, verbose), PackKind.ZIP if zip_ else PackKind.USDZ
    done = pack_scene(scene, scenes_folder, kind, _file(out or OUT, scene, kind.value))
    facts: dict[str, Any] = {
        "kind": kind.value,
        "files": done.files,
        "bytes": done.size,
        "sha256": done.sha256,
        "built": done.built,
    }
    measured = measures_at(scenes_folder / done.scene_id)
    output.made(done.scene_id, done.file.parent, measured, file=str(done.file), **facts)
    output.line(f"{done.file}: {done.files} files, {done.size / 1e6:.1f} MB")
    elsewhere = () if scenes_folder == SCENES else ("--scenes-folder", scenes_folder)
    output.look(done.scene_id, *elsewhere)


def _file(out: Path, scene: str, suffix: str) -> Path:
    """The file to write: other programs go by its suffix, so it always has the one of its kind."""
    if out == OUT or out.is_dir():
        return out / f"{scene}.{suffix}"
    return out if out.suffix.lower() == f".{suffix}" else out.with_name(f"{out.name}.{suffix}")
