"""Measure how diverse kitchens are: how evenly their traits are spread, and how far each is from its nearest.

Evenness of a trait is its Shannon entropy over that of an even spread, 0 to 1. An even spread is one over all values
that the trait can have, or over as many as there are kitchens, whichever is less: six kitchens cannot show a hundred
floors. It is 0 where all kitchens are alike in that.

The distance of two kitchens is the sum of these parts, 0 to 1; docs/howto/kitchens/sample.md explains it:

    plan      0.20  where the plans are others
    lengths   0.15  mean difference of the lengths, each as a share of its range; all of it where the plans are others
    style     0.10  where the styles are others
    surfaces  0.25  share of wall, floor, worktops and cabinets with other finishes
    fronts    0.05  where the fronts or handles of the cabinets are others
    fixtures  0.25  share of the roles of either with another model in the other, or with none
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from casa_assets.core.numeric import Floats, Ints
from casa_assets.core.system import kept_json
from casa_assets.model.kitchen.choices import Surface

DIVERSITY = "diversity.json"
PLAN, LENGTHS, STYLE, SURFACES, FRONTS, FIXTURES = 0.20, 0.15, 0.10, 0.25, 0.05, 0.25
# Two kitchens below this distance are near duplicates: of one plan, and alike in most of the rest.
NEAR = 0.2
# Floor areas are counted in steps of this many square metres, from the first to the last bound; what is beyond a bound
# is counted in the step beside it.
STEP_M2, SMALLEST_M2, LARGEST_M2 = 3.0, 9.0, 45.0
ABSENT = -1


@dataclass(frozen=True)
class Traits:
    """Traits of a kitchen.

    Attributes:
        lengths: length of the plan -> its position between its bounds, 0 to 1.
        floor_m2: width times depth of the room.
        surfaces: wall, floor, counter, cabinet -> finish.
        fronts: kind of the base units' fronts and of their handles, such as `shaker, bar`.
        fixtures: role -> model, `family/preset`, of the fixture in that role.
    """

    id: str
    plan: str
    style: str
    lengths: Mapping[str, float]
    floor_m2: float
    surfaces: Mapping[str, str]
    fronts: str
    fixtures: Mapping[str, str]


@dataclass(frozen=True)
class Choices:
    """How many values each trait can have, however a kitchen is drawn."""

    plans: int
    styles: int
    fronts: int
    surfaces: Mapping[str, int]
    fixtures: Mapping[str, int]


@dataclass(frozen=True)
class Neighbours:
    """Distances of kitchens from the ones most like them; None of fewer than two kitchens.

    Attributes:
        least, median: of these distances. near: how many kitchens have one within NEAR.
        closest: ids of the two that are most alike.
    """

    least: float | None
    median: float | None
    near: int
    closest: tuple[str, str] | None


@dataclass(frozen=True)
class Diversity:
    """How diverse some kitchens are. Evenness is 0 to 1, or None for fewer than two values or kitchens.

    Attributes:
        kitchens: their number. surfaces, roles: evenness of the finishes, by surface, and of the models, by role.
        fixtures: mean evenness of the models over all roles.
    """

    kitchens: int
    plans: float | None
    styles: float | None
    room_sizes: float | None
    fronts: float | None
    surfaces: dict[str, float | None]
    fixtures: float | None
    roles: dict[str, float | None]
    neighbours: Neighbours


def diversity_of(found: Sequence[Traits], possible: Choices) -> Diversity:
    """How diverse some kitchens are."""
    names = sorted({role for traits in found for role in traits.fixtures})
    roles = {
        role: evenness([t.fixtures[role] for t in found if role in t.fixtures], possible.fixtures[role])
        for role in names
    }
    known = [value for value in roles.values() if value is not None]
    return Diversity(
        kitchens=len(found),
        plans=evenness([t.plan for t in found], possible.plans),
        styles=evenness([t.style for t in found], possible.styles),
        room_sizes=evenness([_size_step(t.floor_m2) for t in found], _size_step(LARGEST_M2) + 1),
        fronts=evenness([t.fronts for t in found], possible.fronts),
        surfaces={s.value: evenness([t.surfaces[s] for t in found], possible.surfaces[s]) for s in Surface},
        fixtures=round(sum(known) / len(known), 4) if known else None,
        roles=roles,
        neighbours=_neighbours(found),
    )


def evenness(values: Sequence[Hashable], possible: int) -> float | None:
    """Return the entropy of values divided by that of an even spread; None for fewer than two values or kitchens.

    `values`: of one trait, one for each kitchen that has it. `possible`: number of values to choose from.
    """
    counts = Counter(values)
    most = min(max(possible, len(counts)), len(values))
    if most < 2:
        return None
    shares = [count / len(values) for count in counts.values()]
    return round(-sum(share * math.log(share) for share in shares) / math.log(most) + 0.0, 4)


def _size_step(floor_m2: float) -> int:
    """Number of the step that an area is counted in, from 0."""
    last = math.ceil((LARGEST_M2 - SMALLEST_M2) / STEP_M2) - 1
    return min(max(math.floor((floor_m2 - SMALLEST_M2) / STEP_M2), 0), last)


def _neighbours(found: Sequence[Traits]) -> Neighbours:
    if len(found) < 2:
        return Neighbours(None, None, 0, None)
    nearest, which = np.empty(len(found)), np.empty(len(found), dtype=int)
    for i, row in enumerate(_distances(found)):
        row[i] = np.inf
        which[i] = int(row.argmin())
        nearest[i] = row[which[i]]
    i = int(nearest.argmin())
    return Neighbours(
        least=round(float(nearest[i]), 4),
        median=round(float(np.median(nearest)), 4),
        near=int((nearest < NEAR).sum()),
        closest=(found[i].id, found[int(which[i])].id),
    )


def _distances(found: Sequence[Traits]) -> Iterator[Floats]:
    """Of each kitchen in turn, its (N,) distances from all; those of thousands take seconds."""
    roles = sorted({role for t in found for role in t.fixtures})
    names = sorted({(t.plan, name) for t in found for name in t.lengths})
    plan, style, fronts = (_numbered([getattr(t, name) for t in found]) for name in ("plan", "style", "fronts"))
    surfaces = np.stack([_numbered([t.surfaces.get(s.value) for t in found]) for s in Surface], axis=1)
    columns = [_numbered([t.fixtures.get(role) for t in found]) for role in roles]
    fixtures = np.stack(columns, axis=1) if columns else np.empty((len(found), 0), dtype=np.int64)
    # NaN where a plan has no such length.
    rows = [[t.lengths.get(name, np.nan) if t.plan == of else np.nan for of, name in names] for t in found]
    lengths = np.array(rows).reshape(len(found), len(names))
    for i in range(len(found)):
        is_other_plan = plan != plan[i]
        gaps = np.abs(lengths - lengths[i])
        counted = np.isfinite(gaps)
        mean_gap = np.where(counted, gaps, 0.0).sum(axis=1) / np.maximum(counted.sum(axis=1), 1)
        has = (fixtures != ABSENT) | (fixtures[i] != ABSENT)
        others = (fixtures != fixtures[i]) & has
        yield (
            PLAN * is_other_plan
            + LENGTHS * np.where(is_other_plan, 1.0, mean_gap)
            + STYLE * (style != style[i])
            + SURFACES * (surfaces != surfaces[i]).mean(axis=1)
            + FRONTS * (fronts != fronts[i])
            + FIXTURES * others.sum(axis=1) / np.maximum(has.sum(axis=1), 1)
        )


def _numbered(values: Sequence[str | None]) -> Ints:
    """(N,) a number for each value, the same for the same; ABSENT for None."""
    numbers = {value: i for i, value in enumerate(sorted({v for v in values if v is not None}))}
    return np.array([ABSENT if value is None else numbers[value] for value in values], dtype=np.int64)


def write_diversity(out: Path, drawn: Diversity, reference: Diversity) -> Path:
    """Write diversity.json of a folder of scenes: of the kitchens in it, and of all plans in all styles."""
    path = out / DIVERSITY
    data = {"near_duplicates_within": NEAR, "kitchens": asdict(drawn), "reference": asdict(reference)}
    path.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return path


def read_diversity(out: Path) -> tuple[Diversity, Diversity] | None:
    """Return the diversity of the kitchens and of the reference from diversity.json, or None if it cannot be read."""
    data, adapter = kept_json(out / DIVERSITY), TypeAdapter(Diversity)
    try:
        return adapter.validate_python(data["kitchens"]), adapter.validate_python(data["reference"])
    except (ValueError, KeyError, TypeError):
        return None


def table_rows(drawn: Diversity, reference: Diversity) -> list[tuple[str, str, str]]:
    """Rows of the table of both: what is measured, of the kitchens, of the reference."""
    mine, theirs = _numbers(drawn), _numbers(reference)
    return [(name, _text(mine[name]), _text(theirs[name])) for name in mine]


def _numbers(found: Diversity) -> dict[str, float | int | None]:
    return {
        "kitchens": found.kitchens,
        "plans": found.plans,
        "styles": found.styles,
        "room sizes": found.room_sizes,
        **{f"{s.value} finishes": found.surfaces[s.value] for s in Surface},
        "fronts and handles": found.fronts,
        "fixture models": found.fixtures,
        "least distance of two": found.neighbours.least,
        "median distance to the nearest": found.neighbours.median,
        f"near duplicates (within {NEAR:g})": found.neighbours.near,
    }


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:,}" if isinstance(value, int) else f"{value:.2f}"
