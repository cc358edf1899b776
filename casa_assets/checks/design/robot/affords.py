"""Find tasks that a kitchen does not afford (fixtures, reach, room for objects)."""

from __future__ import annotations

from casa_assets.checks.check import Measurement, least
from casa_assets.checks.design.subject import DesignSubject


def tasks_are_supported(subject: DesignSubject, limit: float) -> Measurement:
    """TSK001: number of the 25 tasks that lack fixtures, joints or sites that a base gets to."""
    lacking = [t for t in subject.tasks if t.wants]
    problems = tuple((f"tasks/{t.task}", f"it wants {t.wants}") for t in lacking)
    return Measurement(float(len(lacking)), problems if len(lacking) > limit else ())


def task_objects_find_room(subject: DesignSubject, limit: float) -> Measurement:
    """TSK002: least share, over the tasks, of sampled objects that can be placed.

    Tasks that lack something else are the business of `tasks_are_supported`.
    """
    tried = [(t.task, t.rate, t.tightest) for t in subject.tasks if t.rate is not None]
    message = "of 200 things only {:.1%} found room within reach at {}; {:.0%} wanted: clear it, or make it larger"
    problems = tuple((f"tasks/{task}", message.format(rate, at, limit)) for task, rate, at in tried if rate < limit)
    return least((rate for _, rate, _ in tried), problems, "it has what it takes for no task (TSK001)")
