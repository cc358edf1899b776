"""Candidates for the frame: what they look like, and what they let find when they are tried out."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from casa_assets.articulate.frame import (
    CANDIDATES,
    SCORE_NAMES,
    candidate_axes,
    candidate_probabilities,
    rotate_fragments,
    score_candidate,
)
from casa_assets.articulate.segment.fragments import MeasuredFragments, measure_fragments
from casa_assets.articulate.segment.orthographic import FRONT, LEFT, SIDES, TOP
from casa_assets.articulate.side_views import measure_side
from tests.unit.articulate.blocks import Part, box, drawers, microwave, together
from tests.unit.articulate.fragmented import in_its_frame

PIXELS = 128


def pieces_of(*parts: Part) -> MeasuredFragments:
    """The pieces of a thing that stands as it should."""
    placed, _ = in_its_frame(*together(*parts)[:2])
    return measure_fragments(placed, placed.fragment_labels, PIXELS)


def whole(name: str) -> MeasuredFragments:
    """One of the things of the tests."""
    return pieces_of({"drawers": drawers, "microwave": microwave}[name]()[:2])


def test_turned_pieces_are_as_if_measured_there(subtests: pytest.Subtests) -> None:
    for front, top in [p for p in product(range(6), repeat=2) if p[0] // 2 != p[1] // 2]:
        with subtests.test(front=front, top=top):
            pieces = whole("microwave")
            found = rotate_fragments(pieces, front, top)
            rotation = candidate_axes(front, top)
            assert np.linalg.det(rotation) == pytest.approx(1.0)
            assert rotation @ SIDES[front][2] == pytest.approx(SIDES[FRONT][2])
            assert rotation @ SIDES[top][2] == pytest.approx(SIDES[TOP][2])
            anew = measure_fragments(found.mesh, found.label, PIXELS)
            assert found.lower == pytest.approx(anew.lower)
            assert found.upper == pytest.approx(anew.upper)
            assert found.visible_area == pytest.approx(anew.visible_area, abs=0.1 * anew.visible_area.max())
            for old, new in zip(found.depth_images, anew.depth_images, strict=True):
                assert old.face.shape == new.face.shape
                assert old.lower == pytest.approx(new.lower, abs=1.1 * new.pixel)
                both = np.isfinite(old.depth) & np.isfinite(new.depth)
                assert float((np.abs(old.depth[both] - new.depth[both]) < 1e-3).mean()) > 0.9


def test_a_candidate_upside_down_or_sideways_finds_less() -> None:
    pieces = whole("drawers")
    right = dict(zip(SCORE_NAMES, score_candidate(pieces, FRONT, TOP), strict=True))
    aside = dict(zip(SCORE_NAMES, score_candidate(pieces, LEFT, TOP), strict=True))
    assert right["drawers"] == pytest.approx(np.log1p(2))
    assert right["front_coverage"] > 0.8
    assert right["no_parts"] == 0.0
    assert aside["drawers"] == 0.0
    assert aside["no_parts"] == 1.0


def test_another_material_in_the_same_plane_is_detail() -> None:
    vertices, faces, _ = together(
        box((0, 0, 0), (0.6, 0.4, 0.3)),
        box((0.05, 0.0, 0.05), (0.3, 0.01, 0.25)),
        box((0.4, 0.0, 0.05), (0.5, 0.01, 0.1)),
    )
    # The windows lie a hair before the box, so that they are what is seen.
    vertices[8:, 1] -= 1e-4
    details = []
    for tint in (np.zeros(len(faces), dtype=np.int64), np.repeat(np.arange(3), 12)):
        placed, _ = in_its_frame(vertices, faces, tint)
        details.append(measure_side(measure_fragments(placed, placed.fragment_labels, PIXELS), FRONT).detail)
    assert details[0] == 0.0
    assert details[1] > 0.02


def test_shares_sum_to_one_and_what_is_known_counts() -> None:
    pieces = whole("drawers")
    even = candidate_probabilities(pieces, dict.fromkeys(CANDIDATES, 0.0))
    assert sum(even.values()) == pytest.approx(1.0)
    assert max(even, key=lambda c: even[c]) == (FRONT, TOP)
    told = candidate_probabilities(pieces, {c: 0.0 if c == (LEFT, TOP) else -50.0 for c in CANDIDATES})
    assert max(told, key=lambda c: told[c]) == (LEFT, TOP)
    assert candidate_probabilities(pieces, {(LEFT, TOP): 0.0}) == {(LEFT, TOP): 1.0}
