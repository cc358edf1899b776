"""Names for the shell to complete, found without importing what makes or reads the things themselves.

A shell asks at each press of a key. So names are taken from the names of files and from the lines of registry/ that
begin a row, and the records behind them are not read; tests hold that they are the names that the registry gives.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import typer

from casa_assets.projects import VARIABLE, data_root, find_project, layers

_ROW = re.compile(r"([A-Za-z][\w-]*):")
_PRESET = re.compile(r"  ([A-Za-z][\w-]*):")
LIBRARY, ARTICULATED, SCENES = Path("out/library"), Path("out/articulated"), Path("out/scenes")
REJECTED = "rejected"
MOST_ASSETS = 200  # of so many, the folders of their categories are offered first


def plans(incomplete: str) -> list[str]:
    """Ids of floor plans."""
    return _starting(incomplete, _files("plans"))


def styles(incomplete: str) -> list[str]:
    """Ids of styles."""
    return _starting(incomplete, _files("styles"))


def kitchens(ctx: typer.Context, incomplete: str) -> list[str]:
    """Ids of kitchens: every plan in every style, and those that are already in the folder of scenes."""
    place = ctx.params.get("scenes_folder") or ctx.params.get("out") or SCENES
    ids = {f"{plan}__{style}" for plan in _files("plans") for style in _files("styles")}
    return _starting(incomplete, sorted({*ids, *built_kitchens(Path(place))}))


def built_kitchens(place: Path) -> list[str]:
    """Ids of the kitchens in a folder, sorted."""
    return sorted(path.parent.name for path in place.glob("*__*/scene.json"))


def families(incomplete: str) -> list[str]:
    """Names of parametric families."""
    return _starting(incomplete, _files("families"))


def presets(ctx: typer.Context, incomplete: str) -> list[str]:
    """Names of the presets of the families named earlier on the line; of all families if none are named."""
    known = _files("families")
    # While an option waits for its value, the words before it are not bound to arguments yet.
    named = [word for word in ctx.params.get("names") or ctx.args if word in known]
    names = named or known
    return _starting(incomplete, sorted({preset for name in names for preset in _presets(name)}))


def categories(incomplete: str) -> list[str]:
    """Ids of categories of things."""
    return _starting(incomplete, sorted({name for layer in _layers() for name in _rows(layer / "categories.yaml")}))


def objects(incomplete: str) -> list[str]:
    """Ids of the categories of which there are objects."""
    return _starting(incomplete, sorted(_rows_of_folder("objects")))


def textures(incomplete: str) -> list[str]:
    """Ids of textures."""
    return _starting(incomplete, sorted({*_rows_of_folder("textures"), *_rows_of_folder("skins"), *_pictures()}))


def robots(incomplete: str) -> list[str]:
    """Names of robots."""
    return _starting(incomplete, _files("robots"))


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
    """Folders directly in a folder, by name; empty if it does not exist."""
    try:
        with os.scandir(place) as found:
            return sorted(Path(one.path) for one in found if one.is_dir())
    except OSError:
        return []


def things(ctx: typer.Context, incomplete: str) -> list[str]:
    """Assets of libraries by path, and kitchens by id."""
    return [*assets(incomplete), *kitchens(ctx, incomplete)]


def _starting(incomplete: str, names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(name for name in names if name.startswith(incomplete)))


def _files(folder: str) -> list[str]:
    return sorted({path.stem for path in _paths_in(folder)})


def _paths_in(folder: str) -> list[Path]:
    """YAML files in a folder of the registry, and of the project in use."""
    return sorted(path for layer in _layers() for path in (layer / folder).glob("*.yaml"))


def _layers() -> tuple[Path, ...]:
    """Folders of registry files. No verb has been called yet, so that a project is looked for here."""
    if not os.environ.get(VARIABLE) and (found := find_project(Path())) is not None:
        return (data_root(), found)
    return layers()


def _rows(path: Path) -> Iterator[str]:
    """Keys on the top level of a YAML file."""
    for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else ():
        if found := _ROW.match(line):
            yield found[1]


def _rows_of_folder(folder: str) -> Iterator[str]:
    for path in _paths_in(folder):
        yield from _rows(path)


def _pictures() -> Iterator[str]:
    """Ids of the pictures of the packs of the project in use."""
    for path in sorted(path for layer in _layers() for path in layer.glob("textures/*/pack.json")):
        try:
            yield from (picture["id"] for picture in json.loads(path.read_text(encoding="utf-8"))["pictures"])
        except (OSError, ValueError, TypeError, KeyError):
            continue  # a verb tells what is wrong with it


def _presets(family: str) -> Iterator[str]:
    for path in (layer / "families" / f"{family}.yaml" for layer in _layers()):
        inside = False
        for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else ():
            if found := _ROW.match(line):
                inside = found[1] == "presets"
            elif inside and (preset := _PRESET.match(line)):
                yield preset[1]


def _paths(incomplete: str) -> list[str]:
    """Files and folders in the folder that a path begins with; folders end with a slash."""
    folder, start = Path(incomplete).parent if not incomplete.endswith("/") else Path(incomplete), incomplete
    if not folder.is_dir():
        return []
    names = (path.as_posix() + ("/" if path.is_dir() else "") for path in folder.iterdir())
    return sorted(name for name in names if name.startswith(start))
