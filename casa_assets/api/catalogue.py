"""List floor plans, styles, families and textures to choose from, and make all that a project describes."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from casa_assets.errors import BatchFault, CasaError
from casa_assets.projects import SETTINGS, project_folder

if TYPE_CHECKING:
    from casa_assets.families.family import Params
    from casa_assets.families.kit.assemble import Family
    from casa_assets.registry.plugins import Plugin

# Make -----------------------------------------------------------------------------------------------------------------
# Make everything that a project describes with one call.

MISUSE = 2  # exit code of commands: wrong use, or a broken machine
ANSWERS = (0, 1, 4)  # exit codes that say how the work ended; others: that it did not
ERROR = "error:"  # begins the line that tells why a command ended with MISUSE


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


def make(project: str | Path | None = None, *, plugins: bool = False) -> tuple[MadeRun, ...]:
    """Run everything that the casa.yaml of a project lists under `runs`, as `casa-assets make` does.

    The commands are run one after the other in separate processes, in the folder of the project. Results of an earlier
    call that are unchanged are kept. Nothing is printed until all have ended.

    Args:
        project: its folder; None: the project in use.
        plugins: run the code in its `plugins/`, which can do whatever you can; a project that is in use with its
            plug-ins runs them in any case.
    Returns:
        Each run, in the order of casa.yaml.
    Raises:
        CasaError: there is no project, a run is wrong (before the first is started), or a command cannot do its work;
            the runs after it are then not made. BatchFault: a bug in the program.
    """
    folder = project_folder() if project is None else Path(project).absolute()
    if folder is None or not (folder / SETTINGS).is_file():
        named = "no project is in use" if project is None else str(project)
        raise CasaError(f"{named}: give a folder with a {SETTINGS}; `casa-assets init` writes one")
    words = [sys.executable, "-m", "casa_assets.cli.main", "make", "--json", "--project", str(folder)]
    done = subprocess.run(
        [*words, *(["--plugins"] if plugins else [])], capture_output=True, text=True, errors="replace", check=False
    )
    runs = tuple(_runs(done.stdout))
    if done.returncode not in ANSWERS:
        name = runs[-1].command if runs and runs[-1].exit_code not in ANSWERS else f"casa-assets make in {folder}"
        told = [line.removeprefix(ERROR).strip() for line in done.stderr.splitlines() if line.startswith(ERROR)]
        if done.returncode == MISUSE:
            raise CasaError(f"{name}: {told[-1] if told else done.stderr.strip()[-1000:]}")
        raise BatchFault([name], done.stderr)
    return runs


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


# Catalogue ------------------------------------------------------------------------------------------------------------
# List the floor plans, styles, families and textures to choose from, and the plug-ins in use.


@dataclass(frozen=True)
class Bounds:
    """Minimum and maximum of a number, both allowed; None if there is no bound. SI units."""

    low: float | None
    high: float | None


@dataclass(frozen=True)
class PlanInfo:
    """A floor plan.

    Attributes:
        name: name for `kitchen`.
        title: name for people, one line.
        defaults: variable length -> its value in the plan, metres.
        bounds: variable length -> bounds within which a seed draws it.
    """

    name: str
    title: str
    defaults: Mapping[str, float]
    bounds: Mapping[str, Bounds]


@dataclass(frozen=True)
class StyleInfo:
    """A style of kitchens: name for `kitchen`, title, and what makes it recognisable in one line."""

    name: str
    title: str
    description: str


@dataclass(frozen=True)
class FamilyInfo:
    """A parametric family of assets.

    Attributes:
        name: name for `build` and `sample`.
        title: name for people, one line.
        group: cabinets, counters, cooking, cold, small, decor or room.
        category: category id of the assets that it makes.
        presets: names of ready members.
        params: type of the parameters of `build`.
        bounds: number -> its bounds; numbers inside a part are named `part.number`.
    """

    name: str
    title: str
    group: str
    category: str
    presets: tuple[str, ...]
    params: type[Params]
    bounds: Mapping[str, Bounds]


def plans() -> Mapping[str, PlanInfo]:
    """All floor plans by name, sorted."""
    from casa_assets.registry.kitchens import plan_names

    return MappingProxyType({name: _plan(name) for name in plan_names()})


def styles() -> Mapping[str, StyleInfo]:
    """All styles by name, sorted."""
    from casa_assets.registry.kitchens import load_style, style_names

    found = (load_style(name)[0] for name in style_names())
    return MappingProxyType({s.id: StyleInfo(s.id, s.title, s.description) for s in found})


def families() -> Mapping[str, FamilyInfo]:
    """All parametric families by name, group by group."""
    from casa_assets.registry.families import family_groups

    return MappingProxyType({f.name: _family(f, group) for group, members in family_groups().items() for f in members})


def surfaces() -> Mapping[str, tuple[str, ...]]:
    """Ids of the textures that each surface of a kitchen (wall, floor, counter, cabinet) can be covered with."""
    from casa_assets.model.kitchen.choices import Surface
    from casa_assets.pipeline.families.finishes import available_finishes

    found = available_finishes().surfaces
    return MappingProxyType({surface.value: tuple(found[surface]) for surface in Surface})


def plugins() -> Mapping[str, Plugin]:
    """The plug-ins in use, by name: of installed packages, and of the project if its code may run (`use_project`).

    Raises:
        CasaError: one cannot be imported, or offers a name that is taken.
    """
    from casa_assets.registry.plugins import load_plugins

    return MappingProxyType({one.plugin.name: one.plugin for one in load_plugins()})


def _plan(name: str) -> PlanInfo:
    from casa_assets.registry.kitchens import load_plan

    plan = load_plan(name)[0]
    lengths = sorted(plan.parameters.items())
    return PlanInfo(
        name,
        plan.title,
        MappingProxyType({key: p.default for key, p in lengths}),
        MappingProxyType({key: Bounds(p.low, p.high) for key, p in lengths}),
    )


def _family(family: Family[Any], group: str) -> FamilyInfo:
    bounds = MappingProxyType(dict(_bounds(family.params)))
    return FamilyInfo(family.name, family.title, group, family.category, tuple(family.presets), family.params, bounds)


def _bounds(params: type[Params], at: str = "") -> list[tuple[str, Bounds]]:
    """Name and bounds of every number of a type of Params, including those of nested Params."""
    from casa_assets.families.family import Params

    found: list[tuple[str, Bounds]] = []
    for name, field in params.model_fields.items():
        kinds = [field.annotation, *getattr(field.annotation, "__args__", ())]
        for kind in kinds:
            if isinstance(kind, type) and issubclass(kind, Params):
                found += _bounds(kind, f"{at}{name}.")
        if any(kind in (int, float) for kind in kinds):
            low, high = (_bound(field.metadata, marks) for marks in (("ge", "gt"), ("le", "lt")))
            found.append((f"{at}{name}", Bounds(low, high)))
    return found


def _bound(marks: list[Any], names: tuple[str, ...]) -> float | None:
    """Number of the first constraint in a field's metadata that has one of these names, as in pydantic's Field."""
    return next((float(getattr(mark, name)) for mark in marks for name in names if hasattr(mark, name)), None)
