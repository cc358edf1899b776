"""Estimate what a run takes, from a sample of its inputs that is worked on and thrown away."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.ingest.sources.found import Found
from casa_assets.ingest.sources.stores.address import StoreRoot
from casa_assets.pipeline.ingest.discover_inputs import discover_inputs
from casa_assets.pipeline.ingest.forecast import Overheads, forecast
from casa_assets.pipeline.ingest.job import Event
from casa_assets.pipeline.ingest.run import Options, ingest

# Resamples of the sample, and the percentiles of what they give between which an estimate is said to lie.
RESAMPLES, LOW, HIGH = 400, 5.0, 95.0
# Runs that are simulated for the interval of one number of cores.
SIMULATED = 20
# Seconds of a run besides the work, as `./dev bench scale` and `./dev bench ingest_again`
# print them; the last is a guess.
START_S, JOB_S, LISTING_S, LEAD_S, END_S = 3.5, 0.036, 0.0005, 0.0078, 0.001


@dataclass(frozen=True)
class Interval:
    """An estimate, and the bounds between which 9 of 10 resamples lie."""

    middle: float
    low: float
    high: float


@dataclass(frozen=True)
class Estimate:
    """What a run would take.

    Attributes:
        inputs: that there are. sampled: that were worked on. kept: of these, what the library has already.
        core_hours, disk_bytes: of all inputs. peak_bytes: of memory, the most that one input of the sample took.
        hours: of the clock, by number of cores. busy: share of the cores' time that is used then.
    """

    inputs: int
    sampled: int
    kept: int
    core_hours: Interval
    disk_bytes: Interval
    peak_bytes: int
    hours: dict[int, Interval]
    busy: dict[int, float]


def sample_run(
    roots: Sequence[Path | StoreRoot], options: Options, sample: int, show_work: Callable[[str], None] | None = None
) -> Generator[Event, None, None]:
    """Work on a sample of the inputs and keep nothing; an event for each, as of a run."""
    yield from ingest(roots, replace(options, dry_run=True, sample=sample), show_work=show_work)


def estimate(events: Sequence[Event], inputs: int, cores: Sequence[int]) -> Estimate:
    """Reckon up what a run takes.

    Args:
        events: of a sample, at least one. inputs: that the run has. cores: for which the time is wanted.
    """
    # Inputs that are kept, or refused before any work, cost nothing but their reading.
    cpu_s = np.array([event.cost.cpu_s if event.cost else 0.0 for event in events])
    clock_s = np.array([event.cost.clock_s if event.cost else 0.0 for event in events])
    written = np.array([event.cost.written_bytes if event.cost else 0 for event in events], dtype=np.float64)
    read_s = float(np.mean([event.seconds.get("read", 0.0) for event in events]))
    overheads = Overheads(START_S, read_s, JOB_S, LISTING_S, LEAD_S, END_S)
    hours, busy = {}, {}
    for count in cores:
        hours[count], busy[count] = _hours(clock_s, inputs, count, overheads)
    return Estimate(
        inputs,
        len(events),
        sum(event.kind == "kept" for event in events),
        _scaled(_means(cpu_s + read_s), inputs / 3600),
        _scaled(_means(written), inputs),
        max((event.cost.peak_bytes for event in events if event.cost), default=0),
        hours,
        busy,
    )


def count_inputs(roots: Sequence[Path | StoreRoot], library: Path) -> int:
    """Number of inputs with a mesh under the roots."""
    return sum(isinstance(found, Found) for found in discover_inputs(roots, library))


def _means(values: Floats) -> Floats:
    """The mean of the sample, then those of its resamples."""
    drawn = np.random.default_rng(0).choice(values, (RESAMPLES, len(values)))
    return np.concatenate([[values.mean()], drawn.mean(axis=1)])


def _scaled(means: Floats, factor: float) -> Interval:
    return Interval(*(factor * float(v) for v in (means[0], *np.percentile(means[1:], (LOW, HIGH)))))


def _hours(clock_s: Floats, inputs: int, cores: int, overheads: Overheads) -> tuple[Interval, float]:
    """Hours of the clock on so many cores, and the share of the cores' time that is used."""
    middle = forecast(clock_s, inputs, cores, overheads)
    random = np.random.default_rng(1)
    resamples = [random.choice(clock_s, len(clock_s)) for _ in range(SIMULATED)]
    others = [forecast(one, inputs, cores, overheads, seed).seconds for seed, one in enumerate(resamples)]
    low, high = np.percentile(others, (LOW, HIGH))
    return Interval(middle.seconds / 3600, float(low) / 3600, float(high) / 3600), middle.busy
