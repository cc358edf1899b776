"""Take the time of the stages of an input, and sum it up over the inputs of a run."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple


class StageTimes:
    """Seconds by name of the stage, in the order in which stages began; a stage that runs again adds to its time."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def of(self, name: str) -> Iterator[None]:
        """Take the time of what is done within, also where it raises."""
        begin = time.perf_counter()
        self.seconds.setdefault(name, 0.0)
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - begin


class Throughput(NamedTuple):
    """Inputs that a stage worked on, and the seconds that it took for all of them, of all workers together."""

    stage: str
    inputs: int
    seconds: float

    @property
    def per_second(self) -> float:
        """Inputs per second of one worker."""
        return self.inputs / self.seconds if self.seconds > 0 else 0.0


def throughput(inputs: Iterable[Mapping[str, float]]) -> list[Throughput]:
    """Sum of the seconds of each stage over inputs, in the order of the stages."""
    counts: dict[str, int] = {}
    seconds: dict[str, float] = {}
    for one in inputs:
        for name, value in one.items():
            counts[name] = counts.get(name, 0) + 1
            seconds[name] = seconds.get(name, 0.0) + value
    return [Throughput(name, counts[name], seconds[name]) for name in counts]
