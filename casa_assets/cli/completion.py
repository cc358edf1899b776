"""Names for the shell to complete, found without importing what makes or reads the things themselves.

A shell asks at each press of a key. So names are taken from the names of files and from the lines of registry/ that
begin a row, and the records behind them are not read; tests hold that they are the names that the registry gives.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

import typer

from casa_assets.projects import VARIABLE, data_root, find_project, layers

_ROW, _INNER_ROW = re.compile(r"([A-Za-z][\w-]*):"), re.compile(r"  ([A-Za-z][\w-]*):")
LIBRARY, ARTICULATED, SCENES = Path("out/library"), Path("out/articulated"), Path("out/scenes")
REJECTED = "rejected"
MOST_ASSETS = 200  # of so many, the folders of their categories are offered first


def _starting(incomplete: str, names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(name for name in names if name.startswith(incomplete)))


def _layers() -> tuple[Path, ...]:
    """Folders of registry files. No verb has been called yet, so that a project is looked for here."""
    if not os.environ.get(VARIABLE) and (found := find_project(Path())) is not None:
        return (data_root(), found)
    return layers()


def _paths_in(pattern: str) -> list[Path]:
    return sorted(path for layer in _layers() for path in layer.glob(pattern))


def _files(folder: str) -> list[str]:
    return sorted({path.stem for path in _paths_in(f"{folder}/*.yaml")})


def _rows(*patterns: str) -> list[str]:
    paths = [path for pattern in patterns for path in _paths_in(pattern)]
    lines = (line for path in paths for line in path.read_text(encoding="utf-8").splitlines())
    return sorted({found[1] for line in lines if (found := _ROW.match(line))})


def _pictures() -> Iterator[str]:
    for path in _paths_in("textures/*/pack.json"):
        try:
            yield from (picture["id"] for picture in json.loads(path.read_text(encoding="utf-8"))["pictures"])
        except (OSError, ValueError, TypeError, KeyError):
            continue  # a verb tells what is wrong with it


def _completing(names: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """Return what Typer calls with the beginning of a name."""

    def complete(incomplete: str) -> list[str]:
        return _starting(incomplete, names())

    return complete


plans, styles, families, robots = (
    _completing(partial(_files, folder)) for folder in ("plans", "styles", "families", "robots")
)
categories = _completing(lambda: _rows("categories.yaml"))
objects = _completing(lambda: _rows("objects/*.yaml"))
textures = _completing(lambda: sorted({*_rows("textures/*.yaml", "skins/*.yaml"), *_pictures()}))


def kitchens(ctx: typer.Context, incomplete: str) -> list[str]:
    """Ids of kitchens: every plan in every style, and those that are already in the folder of scenes."""
    place = ctx.params.get("scenes_folder") or ctx.params.get("out") or SCENES
    ids = {f"{plan}__{style}" for plan in _files("plans") for style in _files("styles")}
    built = {path.parent.name for path in Path(place).glob("*__*/scene.json")}
    return _starting(incomplete, sorted(ids | built))


def presets(ctx: typer.Context, incomplete: str) -> list[str]:
    """Names of the presets of the families named earlier on the line; of all families if none are named."""
    known = _files("families")
    # While an option waits for its value, the words before it are not bound to arguments yet.
    named = [word for word in ctx.params.get("names") or ctx.args if word in known]
    return _starting(incomplete, sorted({preset for name in named or known for preset in _presets(name)}))


def _presets(family: str) -> Iterator[str]:
    for path in _paths_in(f"families/{family}.yaml"):
        inside = False
        for line in path.read_text(encoding="utf-8").splitlines():
            if found := _ROW.match(line):
                inside = found[1] == "presets"
            elif inside and (preset := _INNER_ROW.match(line)):
                yield preset[1]


def assets(incomplete: str) -> list[str]:
    """Folders of the assets in the libraries that are in their usual places, as paths; and files below a path."""
    known = [name for place in (LIBRARY, ARTICULATED) for name in _assets_of(place, incomplete)]
    return _starting(incomplete, [*known, *_paths(incomplete)])


def _assets_of(place: Path, incomplete: str) -> list[str]:
    """Folders of the assets of a library as far as they begin with what is typed; those of categories where many do.

    Names of folders alone are read, and of no category that what is typed rules out.
    """
    found: list[str] = []
    shelves = [path.as_posix() for path in _folders(place) if path.name != REJECTED and path.name[0] != "."]
    shelves = [name for name in shelves if f"{name}/".startswith(incomplete) or incomplete.startswith(f"{name}/")]
    for shelf in shelves:
        found += [path.as_posix() for path in _folders(Path(shelf)) if path.as_posix().startswith(incomplete)]
        if len(found) > MOST_ASSETS and len(shelves) > 1:
            return [f"{name}/" for name in shelves]
    return found


def _folders(place: Path) -> list[Path]:
    try:
        with os.scandir(place) as found:
            return sorted(Path(one.path) for one in found if one.is_dir())
    except OSError:
        return []


def _paths(incomplete: str) -> list[str]:
    """Files and folders in the folder that a path begins with; folders end with a slash."""
    folder = Path(incomplete) if incomplete.endswith("/") else Path(incomplete).parent
    names = (path.as_posix() + "/" * path.is_dir() for path in (folder.iterdir() if folder.is_dir() else ()))
    return sorted(name for name in names if name.startswith(incomplete))


def things(ctx: typer.Context, incomplete: str) -> list[str]:
    """Assets of libraries by path, and kitchens by id."""
    return [*assets(incomplete), *kitchens(ctx, incomplete)]
