"""A kitchen as the checks of design, ways and tasks see it: its facts, and what is worked out of them once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from casa_assets.checks.design.robot.floor_map import FloorMap
from casa_assets.checks.design.robot.parking import ParkingPlaces, find_parking
from casa_assets.checks.design.robot.task_view import Afforded, AtomicTask, TaskView
from casa_assets.checks.design.robot.tasks import afforded, atomic_tasks
from casa_assets.model.kitchen.floor import KitchenFacts


@dataclass(frozen=True, eq=False)
class DesignSubject:
    """A kitchen's facts; a subject is equal to itself alone.

    Attributes:
        facts: from layouts.facts.facts_of.
        seed: of the samples with which tasks are tried.
    """

    facts: KitchenFacts
    seed: int = 0

    @cached_property
    def floor(self) -> FloorMap:
        """The floor as a grid."""
        return FloorMap(self.facts)

    @cached_property
    def parking(self) -> ParkingPlaces:
        """Parking places of a robot's base."""
        return find_parking(self.facts, self.floor)

    @cached_property
    def tasks(self) -> tuple[Afforded, ...]:
        """What is afforded for each task."""
        return afforded(self.facts, self.floor, self.parking, self.seed)

    @cached_property
    def atomic_tasks(self) -> tuple[AtomicTask, ...]:
        """With what the tasks of RoboCasa v1.0 can be done."""
        return atomic_tasks(TaskView(self.facts, self.floor, self.parking))
