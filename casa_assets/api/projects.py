"""Projects, whose own plans, styles, families and textures functions of this package use; pictures as textures."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, Self, TypeVar

from pydantic import ValidationError

from casa_assets.api import assets, catalogue, kitchen, library
from casa_assets.errors import BatchFault, CasaError, UnknownId
from casa_assets.model.kitchen.choices import Surface
from casa_assets.projects import (
    PluginUse,
    ProjectUse,
    enter,
    folder_of_project,
    leave,
    plugin_use,
    project_folder,
    read_again,
)
from casa_assets.runs.outcome import writing
from casa_assets.textures.pack_entry import PictureDescription
from casa_assets.textures.run.packs import PackOptions, PackReport, ingest_pack

P = ParamSpec("P")
R = TypeVar("R")

MISUSE = 2  # exit code of commands: wrong use, or a broken machine
ANSWERS = (0, 1, 4)  # exit codes that say how the work ended; others: that it did not
ERROR = "error:"  # begins the line on why a command ended with MISUSE


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
        licence: SPDX id, or the text of the licence. generator: program or model that made the pictures.
        substance: id of a substance. library: folder to write to, instead of the project in use.
    Returns:
        Folder of the pack, its `pictures`, those that were `refused` with the reasons, and whether it `changed`.
    Raises:
        UnknownId: no such surface. CasaError: there is no such folder, an id is taken, or there is neither a project
            nor a `library` to write to. RegistryError: `pack.yaml` is wrong. OutputError: the folder cannot be written
            to.
    """
    place = project_folder() if library is None else Path(library)
    if place is None:
        raise CasaError("say where the pack is to be: casa.Project(folder).ingest_textures(...), or library=folder")
    if surface and surface not in list(Surface):
        raise UnknownId("surface", surface, [one.value for one in Surface])
    try:
        description = PictureDescription(
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
        return ingest_pack(Path(source), PackOptions(library=place, pack=pack or None, flags=description))


@dataclass(frozen=True)
class MadeRun:
    """A run of a project, which is a command that has ended.

    Attributes:
        command: such as `casa-assets scenes build --out=out/scenes -- loft__workshop`.
        exit_code: 0: success; 1: something was rejected or failed; 4: a person has to decide something.
        rows: its output with `--json`, a row for each item that it made or kept: `id`, `verdict`, `folder` and more;
            empty for a command without `--json`.
    """

    command: str
    exit_code: int
    rows: tuple[Mapping[str, Any], ...]

    @property
    def passed(self) -> bool:
        """True if nothing was rejected or failed, and a person has nothing to decide."""
        return self.exit_code == 0


def _in_project(function: Callable[P, R]) -> Callable[Concatenate[Project, P], R]:
    """Make a method of a function of the package: it uses the project."""

    @wraps(function)
    def method(self: Project, /, *args: P.args, **kwargs: P.kwargs) -> R:
        with self:
            return function(*args, **kwargs)

    return method


class Project:
    """A project: a folder with a `casa.yaml`, whose plans, styles, families and so on are added to the package's.

    Its methods are functions of the package that use it, and kitchens that they return keep to it. In a `with` block
    everything uses it: checks of assets, `Library`, `batch`. Several projects can be used side by side. Their files
    are read once; a new Project reads them again.

    Attributes:
        path: its folder.
    """

    def __init__(self, path: str | Path, *, plugins: bool = False) -> None:
        """Open a folder with a `casa.yaml`, else CasaError; `plugins`: run the code in its `plugins/`."""
        self.path = folder_of_project(path)
        self._use = ProjectUse(self.path, PluginUse.ALL if plugins else plugin_use())
        read_again()

    def __enter__(self) -> Self:
        """Use it until the end of the block."""
        enter(self._use)
        return self

    def __exit__(self, *_: object) -> None:
        leave()

    kitchen = _in_project(kitchen.kitchen)
    build = _in_project(assets.build)
    load = _in_project(assets.load)
    ingest = _in_project(library.ingest)
    articulate = _in_project(library.articulate)
    ingest_textures = _in_project(ingest_textures)
    plans = _in_project(catalogue.plans)
    styles = _in_project(catalogue.styles)
    families = _in_project(catalogue.families)
    surfaces = _in_project(catalogue.surfaces)
    plugins = _in_project(catalogue.plugins)

    def make(self) -> tuple[MadeRun, ...]:
        """Run everything that its casa.yaml lists under `runs`, as `casa-assets make` does.

        The commands are run one after the other in separate processes, in its folder. Results of an earlier call that
        are unchanged are kept. Nothing is printed until all have ended.

        Raises:
            CasaError: a run is wrong (before the first is started), or a command cannot do its work; the runs after it
                are then not made. BatchFault: a bug in the program.
        """
        words = [sys.executable, "-m", "casa_assets.cli.main", "make", "--json", "--project", str(self.path)]
        words += ["--plugins"] * (self._use.plugins is PluginUse.ALL)
        done = subprocess.run(words, capture_output=True, text=True, errors="replace", check=False)
        runs = tuple(_runs(done.stdout))
        if done.returncode in ANSWERS:
            return runs
        name = runs[-1].command if runs and runs[-1].exit_code not in ANSWERS else f"casa-assets make in {self.path}"
        if done.returncode != MISUSE:
            raise BatchFault([name], done.stderr)
        errors = [line.removeprefix(ERROR).strip() for line in done.stderr.splitlines() if line.startswith(ERROR)]
        raise CasaError(f"{name}: {errors[-1] if errors else done.stderr.strip()[-1000:]}")


def _runs(printed: str) -> Iterator[MadeRun]:
    """Parse the output of `casa-assets make --json`: the rows of each run, then a row about the run itself."""
    rows: list[Mapping[str, Any]] = []
    for line in printed.splitlines():
        try:
            row = json.loads(line)
        except ValueError:
            continue
        if not isinstance(row, dict):
            continue
        if "exit_code" in row:
            yield MadeRun(row["id"], row["exit_code"], tuple(rows))
            rows = []
        else:
            rows.append(row)
