"""A walk lists the files that code enters, in order, and no others."""

from __future__ import annotations

from pathlib import Path

from benchmarks.walk import ROOT, sentence, walked
from casa_assets import errors, projects


def test_files_are_listed_in_the_order_in_which_they_are_entered() -> None:
    def walk(_: Path) -> None:
        errors.UnknownId("plan", "l_smal", ["l_small"])
        projects.data_root()

    found = {Path(path).name: count for path, count in walked(walk).items()}
    assert list(found) == ["errors.py", "projects.py"]
    assert min(found.values()) >= 1


def test_sentences_are_on_one_line() -> None:
    assert sentence(ROOT / "benchmarks" / "walk.py").endswith("in their order.")
