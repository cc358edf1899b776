"""Find fixed things that float: nothing below, above or beside holds them."""

from __future__ import annotations

import mujoco
import numpy as np

from casa_assets.checks.check import Measurement
from casa_assets.checks.scene.subject import SceneSubject, around, boxes, meet
from casa_assets.core.typing import Floats, Ints

FLOOR, WALL, CEILING = "floor", "wall", "ceiling"
ROOM = (FLOOR, WALL, CEILING)
# How far a thing may be from what holds it, metres: feet are adjusted, walls are uneven and have skirting or tiles
# between, canopies of lamps cover a gap.
FROM_FLOOR_M, FROM_WALL_M, FROM_CEILING_M, FROM_OTHER_M = 0.002, 0.012, 0.005, 0.002
# What is held by its neighbours, at any side.
BESIDE = frozenset(
    {"filler", "cabinet_panel", "cornice", "toe_kick", "sink", "hob", "skirting", "backsplash", "curtain"}
)
# What hangs on a wall even near the floor. All else whose foot is lower than this has to stand on the floor.
HUNG_LOW = frozenset({"outlet", "switch", "window", "door", "curtain", "wall_panelling"})
LOW_M = 0.6
# Screwed to the sides of the cabinet round it.
BUILT_IN, HOUSING = frozenset({"microwave", "wall_oven"}), "housing_cabinet"
HIGHER_M = 0.004  # as the limit collider_bounds_m of single assets grants
MM = 1000.0


def fixed_things_are_supported(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN008: number of fixed things that nothing holds.

    What stands by its weight is let go in the checks of rest.
    """
    assert limit is not None
    tester = SupportTester(subject)
    held = [p.name for p in subject.scene.placements if subject.category(p.name) in ROOM]
    waiting = [p.name for p in subject.fixed if p.name not in held]
    # From thing to thing: the wall holds the shelf, the shelf holds the jar.
    fresh = list(held)
    while fresh:
        caught = [name for name in waiting if any(tester.holds(name, other) for other in fresh)]
        waiting = [name for name in waiting if name not in caught]
        fresh = caught
    problems = [(f"placements/{name}", _says(tester, name)) for name in waiting]
    return Measurement(float(len(waiting)), tuple(problems) if len(waiting) > limit else ())


def _says(tester: SupportTester, name: str) -> str:
    below = tester.bounds[name][0, 2] - tester.floor
    return f"is held by nothing: its foot is {below * MM:.0f} mm over the floor; set it on, or against, what carries it"


class SupportTester:
    """Tests whether one placement holds another."""

    def __init__(self, subject: SceneSubject) -> None:
        self.subject = subject
        self.boxes: dict[str, Floats] = {
            name: boxes(subject.model, subject.data, geoms) for name, geoms in subject.geoms_of.items()
        }
        self.bounds = {name: around(found) for name, found in self.boxes.items()}
        floors = [self.bounds[n][1, 2] for n in self.bounds if subject.category(n) == FLOOR]
        self.floor = float(max(floors, default=0.0))
        assets = subject.assets
        seen = {a.id: float(a.bounds[0, 2]) for a in subject.scene.assets}
        # Upright, as fixed things are.
        self.feet = {p.name: p.pose.position[2] + seen[assets[p.name].id] for p in subject.scene.placements}
        # Things that are lowered by a little, to feel what is below them.
        self.lowered = mujoco.MjData(subject.model)
        self.lowered.geom_xmat[:] = subject.data.geom_xmat

    def holds(self, name: str, other: str) -> bool:
        """True if a thing that is itself held holds another."""
        kind, carrier = self.subject.category(name), self.subject.category(other)
        low = self.bounds[name][0, 2] - self.floor < LOW_M
        if carrier == FLOOR:
            return self._stands_on(name, other, FROM_FLOOR_M)
        if kind in BUILT_IN and carrier == HOUSING and self._near(name, other, FROM_OTHER_M):
            return True
        if kind in BESIDE:
            return self._near(name, other, FROM_WALL_M if carrier == WALL else FROM_OTHER_M)
        if carrier == WALL:
            return (not low or kind in HUNG_LOW) and self._near(name, other, FROM_WALL_M)
        if carrier == CEILING:
            return self._near(name, other, FROM_CEILING_M)
        return self._stands_on(name, other, FROM_OTHER_M)

    def _near(self, name: str, other: str, gap: float) -> bool:
        """True if two things come as near as that, in any direction."""
        return self._closest(self.subject.data, name, other, gap) <= gap

    def _stands_on(self, name: str, other: str, gap: float) -> bool:
        """True if a thing that is lowered by `gap` goes into what it did not go into before.

        What is touched of a thing may end a little higher than what is seen of it; it is what is seen that stands.
        """
        gap += float(np.clip(self.bounds[name][0, 2] - self.feet[name], 0.0, HIGHER_M))
        if not self._near(name, other, gap):
            return False
        before = self._closest(self.subject.data, name, other, gap)
        self.lowered.geom_xpos[:] = self.subject.data.geom_xpos
        self.lowered.geom_xpos[self.subject.geoms_of[name], 2] -= gap
        after = self._closest(self.lowered, name, other, gap)
        return after <= 0.0 and after < before - gap / 4

    def _closest(self, data: mujoco.MjData, name: str, other: str, gap: float) -> float:
        """Distance of two things, metres; negative is a depth; more than `gap` where they are farther apart."""
        mine, theirs = self.subject.geoms_of[name], self.subject.geoms_of[other]
        near = meet(self.boxes[name][:, None], self.boxes[other][None], 2 * gap)
        least = 2 * gap
        for i, k in np.argwhere(near):
            least = min(least, _distance(self.subject.model, data, mine, theirs, int(i), int(k), 2 * gap))
        return least


def _distance(
    model: mujoco.MjModel, data: mujoco.MjData, mine: Ints, theirs: Ints, i: int, k: int, most: float
) -> float:
    return float(mujoco.mj_geomDistance(model, data, int(mine[i]), int(theirs[k]), most, None))
