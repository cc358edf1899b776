"""What a run is said to take, from a sample of its inputs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from casa_assets.pipeline.ingest.estimate import count_inputs, estimate, sample_run
from casa_assets.pipeline.ingest.job import Cost, Event
from casa_assets.pipeline.ingest.run import Options
from tests.libraries import box_obj, casa_here

pytestmark = pytest.mark.content("code", "pipeline.ingest", keep=0)


def event(cpu_s: float, written: int, peak: int = 10) -> Event:
    return Event("accepted", 4, "a", seconds={"read": 0.5}, cost=Cost(cpu_s, peak, written, cpu_s))


def test_a_sample_is_scaled_up() -> None:
    found = estimate([event(9.5, 100), event(19.5, 300, 50)], 3600, (1, 100))
    assert found.core_hours.middle == pytest.approx(15)
    assert 10 <= found.core_hours.low < 15 < found.core_hours.high <= 20
    assert found.disk_bytes.middle == pytest.approx(200 * 3600)
    assert found.peak_bytes == 50
    # One core takes all of it, a hundred a hundredth, with what the leading process needs.
    assert found.hours[1].middle == pytest.approx(15, rel=0.02)
    assert found.hours[100].middle == pytest.approx(0.15, rel=0.1)


def test_what_is_kept_costs_nothing_but_its_reading() -> None:
    kept = Event("kept", 2, "b")
    found = estimate([event(20.0, 100), kept], 100, (1,))
    assert found.kept == 1
    assert found.disk_bytes.middle == pytest.approx(50 * 100)


@pytest.fixture(scope="module")
def boxes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six boxes of different sizes."""
    folder = tmp_path_factory.mktemp("boxes")
    for number in range(6):
        (folder / f"box_{number}.obj").write_text(box_obj((0.1 + 0.01 * number, 0.1, 0.2)), encoding="utf-8")
    return folder


def test_a_sample_is_the_same_each_time_and_leaves_nothing(boxes: Path, tmp_path: Path) -> None:
    options = Options(tmp_path / "library", category="box", jobs=1)
    first, again = ([event.path for event in sample_run([boxes], options, 1)] for _ in range(2))
    assert first == again
    assert len(first) == 1
    assert count_inputs([boxes], tmp_path / "library") == 6
    assert not (tmp_path / "library").exists()


def test_the_command_line_prints_it(boxes: Path, tmp_path: Path) -> None:
    order = ("ingest", boxes, "--category", "box", "--library", tmp_path / "x", "--estimate", 1, "--cores", 8)
    done = casa_here(*order, "--json")
    assert done.returncode == 0, done.stderr
    row = json.loads(done.stdout)
    assert (row["inputs"], row["sampled"]) == (6, 1)
    assert row["hours"]["8"]["middle"] > 0
    done = casa_here(*order)
    assert "6 inputs, by 1 of them" in done.stdout
    assert not (tmp_path / "x").exists()
