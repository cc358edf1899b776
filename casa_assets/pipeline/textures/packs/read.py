"""Read the packs of a project, or of a library."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from pydantic import ValidationError

from casa_assets.errors import OutputError
from casa_assets.projects import project_folder
from casa_assets.textures.packs.entry import Pack

# Folder of packs in a project or a library, and the file in each that says what it holds.
FOLDER, PACK = "textures", "pack.json"


def load_pack(folder: Path) -> Pack:
    """The pack in a folder. Raises OutputError where pack.json is missing or damaged."""
    try:
        return Pack.from_json((folder / PACK).read_text(encoding="utf-8"))
    except (OSError, ValidationError, ValueError) as error:
        raise OutputError(
            str(folder / PACK), f"cannot be read: {str(error).splitlines()[0]}; ingest it again"
        ) from error


def packs_of(project: Path) -> Iterator[tuple[Path, Pack]]:
    """The packs of a project with their folders, sorted by name. Raises OutputError where a pack.json is damaged."""
    for path in sorted((project / FOLDER).glob(f"*/{PACK}")):
        yield path.parent, load_pack(path.parent)


def credits_of_pictures(names: Collection[str]) -> list[dict[str, str]]:
    """What the packs of the project in use say of the makers of pictures: a row for each of these ids that is one."""
    project = project_folder()
    pictures = (p for _, pack in (packs_of(project) if project is not None else ()) for p in pack.pictures)
    found = {p.id: p for p in pictures if p.id in names}
    return [
        {"id": name, "licence": p.licence, "author": p.author, "generator": p.generator}
        for name, p in sorted(found.items())
    ]
