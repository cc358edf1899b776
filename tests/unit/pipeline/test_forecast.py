"""The model of a run: what must hold of any schedule."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.pipeline.ingest import forecast as module
from casa_assets.pipeline.ingest.forecast import Overheads, forecast

NONE = Overheads()


def test_one_worker_takes_the_sum() -> None:
    assert forecast([2.0], 50, 1, NONE).seconds == pytest.approx(100)


def test_the_inputs_of_a_run_are_taken_as_they_are() -> None:
    assert forecast([5.0, 1.0, 1.0, 1.0], 4, 2, NONE).seconds == pytest.approx(5)
    assert forecast([1.0, 1.0, 1.0, 5.0], 4, 2, NONE).seconds == pytest.approx(6)


def test_what_a_job_takes_besides_is_added() -> None:
    assert forecast([2.0, 3.0], 2, 1, Overheads(start_s=1.0, job_s=0.5)).seconds == pytest.approx(7)


def test_equal_inputs_are_shared_out() -> None:
    found = forecast([2.0], 80, 8, NONE)
    assert found.seconds == pytest.approx(20)
    assert found.busy == pytest.approx(1)
    assert found.tail_s == 0


def test_more_workers_than_inputs_take_as_long_as_the_longest() -> None:
    assert forecast([1.0, 7.0], 100, 1000, NONE).seconds == pytest.approx(7)


def test_a_schedule_keeps_its_bounds() -> None:
    known = np.random.default_rng(3).lognormal(1.0, 1.2, 500)
    drawn = np.random.default_rng(0).choice(known, 400)
    for workers in (2, 16, 64):
        found = forecast(known, 400, workers, NONE)
        fair = drawn.sum() / workers
        assert fair <= found.seconds <= fair + drawn.max()  # Graham's bound of list scheduling


def test_the_leading_process_bounds_a_large_cluster() -> None:
    slow = Overheads(lead_s=0.1)
    assert forecast([10.0], 10_000, 1000, slow).seconds >= 1000
    assert forecast([10.0], 10_000, 10, slow).seconds == pytest.approx(10_000, rel=0.02)


def test_overheads_are_added() -> None:
    extra = Overheads(start_s=5, survey_s=0.5, end_s=0.01)
    assert forecast([2.0], 80, 8, extra).seconds == pytest.approx(20 + 5 + 0.5 * 80 / 8 + 0.8)


def test_what_is_not_simulated_is_shared_out_as_if_it_were(monkeypatch: pytest.MonkeyPatch) -> None:
    known = np.random.default_rng(5).lognormal(1.0, 1.0, 2000)
    whole = forecast(known, 20_000, 16, Overheads(lead_s=0.01, survey_s=0.1))
    monkeypatch.setattr(module, "MOST_SIMULATED", 4_000)
    part = forecast(known, 20_000, 16, Overheads(lead_s=0.01, survey_s=0.1))
    assert part.seconds == pytest.approx(whole.seconds, rel=0.03)
