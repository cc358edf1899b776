"""Times of entries: the last count, and the file does not grow with every run."""

from __future__ import annotations

from pathlib import Path

from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.library.run_times import (
    MOST_LINES_PER_ENTRY,
    NAME,
    Cost,
    keep_times,
    read_costs,
    read_times,
    tidy_times,
)


def test_the_file_is_written_anew_where_it_has_grown_by_many_runs(tmp_path: Path) -> None:
    library = Library(tmp_path)
    tidy_times(library)  # nothing is there yet
    path = library.cache / NAME
    for run in range(MOST_LINES_PER_ENTRY):
        keep_times(library, "mug_a", {"load": run + 0.25})
        keep_times(library, "mug_b", {"load": run + 0.5})
    before = path.read_text(encoding="utf-8")
    tidy_times(library)
    assert path.read_text(encoding="utf-8") == before
    keep_times(library, "mug_a", {"load": 9.25})
    tidy_times(library)
    assert len(path.read_text(encoding="utf-8").splitlines()) == 2
    assert read_times(library) == {"mug_a": {"load": 9.25}, "mug_b": {"load": MOST_LINES_PER_ENTRY - 0.5}}


def test_a_cost_is_that_of_the_last_time(tmp_path: Path) -> None:
    library = Library(tmp_path)
    keep_times(library, "mug_a", {"load": 0.5}, Cost(1.25, 10, 20, 1.5))
    keep_times(library, "mug_b", {"load": 0.5}, Cost(2.0, 11, 21, 1.5))
    keep_times(library, "mug_b", {"load": 0.5})
    assert read_costs(library) == {"mug_a": Cost(1.25, 10, 20, 1.5)}
    for _ in range(3 * MOST_LINES_PER_ENTRY):
        keep_times(library, "mug_c", {"load": 0.5}, Cost(3.0, 12, 22, 1.5))
    tidy_times(library)
    assert read_costs(library) == {"mug_a": Cost(1.25, 10, 20, 1.5), "mug_c": Cost(3.0, 12, 22, 1.5)}
