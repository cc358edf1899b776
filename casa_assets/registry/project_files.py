"""Names of the files and folders of a project that are laid over registry/.

They are in a module that reads none of them: the cache key of code that reads registry files includes the files that it
names (`cache/cache_key.py`).
"""

from __future__ import annotations

import difflib
from pathlib import Path

from casa_assets.errors import RegistryError
from casa_assets.projects import SETTINGS

# What a project may state. `learned/` and `confidence.yaml` are fitted to the code of the package.
TABLES = (
    "categories",
    "classes",
    "densities",
    "fixtures",
    "habits",
    "limits",
    "look_alikes",
    "look_rules",
    "looks",
    "materials",
    "other_things",
    "rejections",
    "roles",
    "substances",
    "waivers",
    "words",
)
FOLDERS = ("contracts", "families", "objects", "plans", "robots", "skins", "styles", "textures")
TEXTURES = ("cabinet.yaml", "counter.yaml", "floor.yaml", "wall.yaml")  # the files in textures/
CODE = "plugins"  # folder of code, which is not laid over anything
NEARLY = 0.75  # likeness of a name to one of these, of difflib, from which on it is taken for a slip


def files_of(project: Path) -> tuple[Path, ...]:
    """The files of a project that are laid over registry/, sorted."""
    tables = (path for name in TABLES if (path := project / f"{name}.yaml").is_file())
    inside = (path for name in FOLDERS for path in (project / name).glob("*.yaml"))
    return tuple(sorted((*tables, *inside)))


def check_names(project: Path) -> None:
    """Raise RegistryError where a file or a folder of a project is all but called as one that would be read."""
    known = [*(f"{name}.yaml" for name in TABLES), *FOLDERS, CODE, SETTINGS]
    for path in sorted(project.iterdir()):
        kin = [name for name in known if path.is_dir() != name.endswith(".yaml")]
        near = difflib.get_close_matches(path.name, kin, n=1, cutoff=NEARLY)
        if near and path.name not in kin:
            raise RegistryError(str(path), 1, "", f"{near[0]!r}, or a name that is not like it", repr(path.name))
    for path in sorted(path for name in FOLDERS for path in (project / name).glob("*.yml")):
        raise RegistryError(str(path), 1, "", "a name that ends in .yaml", repr(path.name))
    for path in sorted((project / "textures").glob("*.yaml")):
        if path.name not in TEXTURES:
            raise RegistryError(str(path), 1, "", f"one of {', '.join(TEXTURES)}", repr(path.name))
