"""Write a small working project: a plan, a style, finishes, a member of a family, a category and its objects."""

from __future__ import annotations

import re
from pathlib import Path

from casa_assets.errors import CasaError
from casa_assets.projects import SETTINGS

STARTER = Path(__file__).parent / "starter"
NAME = "my_kitchens"  # in the starter's casa.yaml


def write_starter(folder: Path) -> tuple[Path, ...]:
    """Copy the starter into a folder; the project is called after the folder. Returns the files, sorted.

    Raises:
        CasaError: a file is there already; nothing is written then.
    """
    sources = sorted(path for path in STARTER.rglob("*.yaml"))
    targets = [folder / path.relative_to(STARTER) for path in sources]
    taken = [str(path) for path in targets if path.exists()]
    if taken:
        raise CasaError(f"{', '.join(taken)}: is there already; name another folder, or take it away")
    for source, target in zip(sources, targets, strict=True):
        text = source.read_text(encoding="utf-8")
        if source.name == SETTINGS:
            text = text.replace(f"name: {NAME}", f"name: {name_of(folder)}")
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    return tuple(targets)


def name_of(folder: Path) -> str:
    """The name of a folder as an id: `My kitchens 2` becomes `my_kitchens_2`."""
    words = re.findall(r"[a-z0-9]+", folder.absolute().name.lower())
    name = "_".join(words)
    return name if re.match(r"[a-z]", name) else f"project_{name}".rstrip("_")
