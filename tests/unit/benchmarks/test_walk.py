"""A walk lists the files that code enters, in order, and no others."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.walk import ROOT, sentence, walked


def test_files_are_listed_in_the_order_in_which_they_are_entered() -> None:
    from casa_assets.core import color, rotation

    def walk(_: Path) -> None:
        rotation.about_axis((0.0, 0.0, 1.0), 0.5)
        color.linear_from_srgb(np.array([0.5, 0.5, 0.5]))

    assert [(Path(path).name, count) for path, count in walked(walk).items()] == [("rotation.py", 1), ("color.py", 1)]


def test_sentences_are_on_one_line() -> None:
    assert sentence(ROOT / "benchmarks" / "walk.py").endswith("in their order.")
