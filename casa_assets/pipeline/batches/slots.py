"""Structures of several kitchens -> the places of one structure that holds each of them."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from scipy.optimize import linear_sum_assignment

from casa_assets.pipeline.batches.structure import GeomKind, SiteKind, Structure, Unit, UnitKind

Kind = TypeVar("Kind", bound=Hashable)


class Slot(NamedTuple):
    """A place that a unit of a kitchen can take, or the world itself.

    Attributes:
        kind: of the units that fit; None for the world.
        geoms, sites: of each of its bodies, kind -> for how many there is room.
    """

    kind: UnitKind | None
    geoms: tuple[Mapping[GeomKind, int], ...]
    sites: tuple[Mapping[SiteKind, int], ...]


class Slots(NamedTuple):
    """Places of a shared structure, and who takes them.

    Attributes:
        world: the place of what does not move. moving: the others.
        tenants: for each kitchen, for each of `moving`, its unit there, or None.
    """

    world: Slot
    moving: tuple[Slot, ...]
    tenants: tuple[tuple[Unit | None, ...], ...]


def slots_for(structures: Sequence[Structure]) -> Slots:
    """Places in which each of some structures fits: of each kind of unit as many as one of them has at most.

    Units with like geoms share a place, so that little room stays empty.
    """
    by_kind: dict[UnitKind, list[list[Unit]]] = defaultdict(lambda: [[] for _ in structures])
    for number, structure in enumerate(structures):
        for unit in structure.units:
            by_kind[unit.kind][number].append(unit)
    moving: list[Slot] = []
    tenants: list[list[Unit | None]] = [[] for _ in structures]
    for kind in sorted(by_kind):
        for here in zip(*_seated(structures, by_kind[kind]), strict=True):
            moving.append(_slot(kind, [(s, t.bodies) for s, t in zip(structures, here, strict=True) if t is not None]))
            for row, tenant in zip(tenants, here, strict=True):
                row.append(tenant)
    world = _slot(None, [(structure, (0,)) for structure in structures])
    return Slots(world, tuple(moving), tuple(map(tuple, tenants)))


def _seated(structures: Sequence[Structure], found: Sequence[Sequence[Unit]]) -> list[list[Unit | None]]:
    """For each structure its units of one kind in the order of places, None where it has none.

    One structure after the other, the largest first, is seated so that places grow by as few geoms as can be.
    """
    places: list[Counter[tuple[int, GeomKind]]] = [Counter() for _ in range(max(map(len, found)))]
    seated: list[list[Unit | None]] = [[None] * len(places) for _ in structures]
    for number in sorted(range(len(structures)), key=lambda one: -len(found[one])):
        needs = [_needs(structures[number], unit) for unit in found[number]]
        growth = np.array([[(need - place).total() for place in places] for need in needs]).reshape(-1, len(places))
        for unit, place in zip(*linear_sum_assignment(growth), strict=True):
            seated[number][place] = found[number][unit]
            places[place] |= needs[unit]
    return seated


def _needs(structure: Structure, unit: Unit) -> Counter[tuple[int, GeomKind]]:
    """(body of a unit, kind) -> how many geoms it has."""
    return Counter(
        {
            (place, kind): len(ids)
            for place, body in enumerate(unit.bodies)
            for kind, ids in structure.geoms.get(body, {}).items()
        }
    )


def _slot(kind: UnitKind | None, tenants: Sequence[tuple[Structure, tuple[int, ...]]]) -> Slot:
    """A place for units of several structures, each with its bodies in the same order."""
    places = range(len(tenants[0][1]))
    geoms = tuple(_most([_counts(s.geoms.get(bodies[place], {})) for s, bodies in tenants]) for place in places)
    sites = tuple(_most([_counts(s.sites.get(bodies[place], {})) for s, bodies in tenants]) for place in places)
    return Slot(kind, geoms, sites)


def _counts(found: Mapping[Kind, Sequence[int]]) -> Counter[Kind]:
    return Counter({kind: len(ids) for kind, ids in found.items()})


def _most(counts: Iterable[Counter[Kind]]) -> dict[Kind, int]:
    """For each kind the most that one of several has, in a fixed order."""
    most: Counter[Kind] = Counter()
    for count in counts:
        most |= count
    return dict(sorted(most.items(), key=lambda item: repr(item[0])))
