"""Predict how long a run takes on so many workers: a discrete model of the run, fed with measured seconds of inputs.

First workers read every input to find its digest; then they take inputs one by one. The process that leads the run
lists the inputs, hands them out, settles copies and puts entries in their places, one after the other, which bounds the
whole from some number of workers on. `./dev bench scale` compares the model with real runs.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.pipeline.workers.engine import waiting_jobs

# The last inputs of a run are simulated one by one, since its end is ragged; before them all workers are busy.
MOST_SIMULATED = 300_000


@dataclass(frozen=True)
class Overheads:
    """Seconds of a run besides the work on its inputs.

    Attributes:
        start_s: until the first worker takes an input. survey_s: of a worker, to read an input and find its digest.
        job_s: of a worker, for each input besides the work on it: its process is started, and ends.
        listing_s, lead_s, end_s: of the leading process for each input: before the work, to publish it, at the end.
    """

    start_s: float = 0.0
    survey_s: float = 0.0
    job_s: float = 0.0
    listing_s: float = 0.0
    lead_s: float = 0.0
    end_s: float = 0.0


@dataclass(frozen=True)
class Forecast:
    """Prediction for a run.

    Attributes:
        seconds: of the clock. busy: share of the workers' time in which they work.
        tail_s: at the end, from the first worker that finds no input left until the last input is done.
    """

    seconds: float
    busy: float
    tail_s: float


def forecast(
    seconds: Sequence[float] | Floats, count: int, workers: int, overheads: Overheads, seed: int = 0
) -> Forecast:
    """Simulate a run.

    Args:
        seconds: that single inputs took. Where the run has as many inputs, these are its inputs in their order; else
            those of the run are drawn from them, long ones as often as they occur.
        count: of inputs. workers: at once. seed: of the draws.
    """
    known = np.asarray(seconds, dtype=np.float64) + overheads.job_s
    simulated = min(count, MOST_SIMULATED)
    drawn = known if count == len(known) <= MOST_SIMULATED else np.random.default_rng(seed).choice(known, simulated)
    before = count - simulated
    surveyed = max(count * overheads.survey_s / workers, count * overheads.listing_s)
    begin = overheads.start_s + surveyed + before * max(float(known.mean()) / workers, overheads.lead_s)
    end, tail = _simulate(drawn, workers, overheads.lead_s, begin)
    total = end + count * overheads.end_s
    work = float(drawn.sum()) + before * float(known.mean()) + count * overheads.survey_s
    return Forecast(total, min(1.0, work / (workers * total)), tail)


def _simulate(drawn: Floats, workers: int, lead_s: float, begin: float) -> tuple[float, float]:
    """When these inputs are done and published, and the seconds between the first idle worker and the last input."""
    free = [begin] * workers
    ahead = workers + waiting_jobs(workers)
    ends = np.empty(len(drawn))
    for number, value in enumerate(drawn.tolist()):
        handed_out = begin + max(0, number - ahead) * lead_s
        ends[number] = max(free[0], handed_out) + value
        heapq.heapreplace(free, ends[number])
    ends.sort()
    # The leading process is a queue of one server: each is published once it and those before it are.
    places = lead_s * np.arange(len(ends))
    published = float(np.max(ends - places)) + lead_s * len(ends)
    return published, float(ends[-1]) - min(free)
