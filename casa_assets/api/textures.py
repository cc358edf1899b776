"""Use the user's own pictures as textures of kitchens."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from casa_assets.errors import CasaError, UnknownId
from casa_assets.model.kitchen.surface import Surface
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.textures.packs.ingest import PackOptions, PackReport, ingest_pack
from casa_assets.projects import project_folder
from casa_assets.textures.packs.entry import PictureDescription


def ingest_textures(
    source: str | Path,
    pack: str = "",
    surface: str = "",
    tile_m: tuple[float, float] | None = None,
    licence: str = "",
    generator: str = "",
    substance: str = "",
    library: str | Path | None = None,
) -> PackReport:
    """Import pictures as a texture pack, as `casa-assets textures ingest` does.

    In a project the pack is written to its `textures/`, and from then on `kitchen(..., surfaces={"wall": id})` accepts
    its pictures. The values given here apply to each picture for which a `pack.yaml` in the folder does not state
    another.

    Args:
        source: folder of pictures.
        pack: name of the pack, which is the prefix of the ids of the pictures; if empty, the name of the folder.
        surface: wall, floor, counter or cabinet.
        tile_m: width and height of the area that a picture shows, metres.
        licence: SPDX id, or the text of the licence.
        generator: program or model that made the pictures.
        substance: id of a substance.
        library: folder to write to, instead of the project in use.
    Returns:
        Folder of the pack, its `pictures`, those that were `refused` with the reasons, and whether it `changed`.
    Raises:
        UnknownId: no such surface. CasaError: there is no such folder, an id is taken, or there is neither a project
            nor a `library` to write to. RegistryError: `pack.yaml` is wrong. OutputError: the folder cannot be written
            to.
    """
    place = project_folder() if library is None else Path(library)
    if place is None:
        raise CasaError("say where the pack is to be: casa.use_project(folder), or library=folder")
    if surface and surface not in list(Surface):
        raise UnknownId("surface", surface, [one.value for one in Surface])
    try:
        said = PictureDescription(
            surface=Surface(surface) if surface else None,
            tile_m=tile_m,
            licence=licence or None,
            generator=generator or None,
            substance=substance or None,
        )
    except ValidationError as error:
        first = error.errors()[0]
        raise CasaError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}, got {first['input']!r}") from None
    with writing(place):
        return ingest_pack(Path(source), PackOptions(library=place, pack=pack or None, flags=said))
