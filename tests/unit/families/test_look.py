"""What a thing looks like: pictures and names to a scorer, and a clear word where there is none."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.errors import CasaError
from casa_assets.library.clip import KIND_PHRASES, PICTURE_PX, VIEWS, class_shares, classify_by_look, load_scorer
from tests.support.asset.articulated_assets import microwave


class Judge:
    """A scorer that says what it is told to, and keeps what it was shown."""

    def __init__(self, kind: str, share: float) -> None:
        self.kind, self.share = kind, share
        self.shown: list[bytes] = []
        self.asked: list[str] = []

    def __call__(self, pictures: Sequence[bytes], names: Sequence[str]) -> tuple[float, ...]:
        self.shown, self.asked = list(pictures), list(names)
        rest = (1.0 - self.share) / (len(names) - 1)
        return tuple(self.share if name == KIND_PHRASES[self.kind] else rest for name in names)


def test_it_is_shown_from_some_sides_and_asked_for_every_kind() -> None:
    judge = Judge("microwave", 0.7)
    assert classify_by_look(microwave(), judge) == ("microwave", 0.7, "CLIP says a microwave oven")
    assert judge.asked == list(KIND_PHRASES.values())
    assert len(judge.shown) == len(set(judge.shown)) == len(VIEWS)
    with Image.open(io.BytesIO(judge.shown[0])) as picture:
        assert picture.size == (PICTURE_PX, PICTURE_PX)


def test_what_is_not_sure_or_something_else_names_nothing_and_every_kind_is_a_fixture_of_the_registry() -> None:
    for judge in (Judge("other", 0.9), Judge("toaster", 0.3)):
        kind, share, message = classify_by_look(microwave(), judge)
        assert (kind, share) == ("", judge.share)
        assert "names nothing" in message
    assert set(KIND_PHRASES) - {"other"} <= set(registry.load().fixtures)


def test_absent_weights_and_an_absent_package_are_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    weights = tmp_path / "ViT-B-32.pt"
    with pytest.raises(CasaError, match="no weights of CLIP"):
        load_scorer(weights)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    weights.write_bytes(b"0")
    with pytest.raises(CasaError, match="not installed"):
        load_scorer(weights)


def test_shares_add_up_and_follow_the_cosines() -> None:
    seen = np.array([[1.0, 0.0], [0.8, 0.6]])
    said = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    found = class_shares(seen, said, 5.0)
    assert float(found.sum()) == pytest.approx(1.0)
    assert list(np.argsort(-found)) == [0, 1, 2]
    assert float(found[0] / found[1]) == pytest.approx(float(np.exp(5.0 * (0.9 - 0.3))))
    assert float(class_shares(seen, said, 1e6).max()) == 1.0, "no overflow"
