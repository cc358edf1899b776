"""casa-assets scenes pack: one file of a kitchen that loads by itself on another machine."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

OUT = Path("out/packs")


def pack(
    scene: Annotated[str, typer.Argument(help="Id of a scene, such as l_small__coastal.")],
    zip_: Annotated[bool, typer.Option("--zip", help="MJCF, USD, scene.json and all that they name.")] = False,
    usdz: Annotated[bool, typer.Option("--usdz", help="The USD and all that it names, as one USDZ.")] = False,
    out: Annotated[Path | None, typer.Option(help="File to write; out/packs/<id>.zip or .usdz by default.")] = None,
    scenes: Annotated[Path, typer.Option(help="Folder of the scenes; what is missing there is built.")] = Path(
        "out/scenes"
    ),
    json_: Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")] = False,
) -> None:
    """Write a kitchen as one file that loads by itself on another machine; built first where it is missing.

    Example:  casa-assets scenes pack l_small__coastal --zip
    """
    from casa_assets.pipeline.kitchens.pack import PackKind, pack_scene

    if zip_ == usdz:
        raise typer.BadParameter("give one of --zip and --usdz")
    kind = PackKind.ZIP if zip_ else PackKind.USDZ
    done = pack_scene(scene, scenes, kind, out or OUT / f"{scene}.{kind}")
    if json_:
        row = {"id": done.scene_id, "file": str(done.file), "kind": kind.value, "files": done.files}
        row |= {"bytes": done.size, "sha256": done.sha256, "built": done.built}
        typer.echo(json.dumps(row, sort_keys=True))
        return
    typer.echo(f"{done.file}: {done.files} files, {done.size / 1e6:.1f} MB")
