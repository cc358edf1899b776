"""Bulging fronts: the stairs of a shell are no seams, and a handle on them is a handle; slopes are no detail."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.fronts.panels import find_panels
from casa_assets.articulate.fronts.relief import FrontRectangle, merge_stairs
from casa_assets.articulate.segment.fragments import MeasuredFragments, measure_fragments
from casa_assets.articulate.segment.orthographic import DepthImage, SideRelief
from tests.unit.articulate.blocks import Floats, Part, box, together
from tests.unit.articulate.fragmented import in_its_frame

COLUMNS = ((0, 20), (20, 40), (40, 160), (160, 180), (180, 200))


def relief_of(depth: Floats) -> SideRelief:
    """A relief of which nothing stands out and nothing is an edge."""
    none = np.zeros(depth.shape, dtype=bool)
    blob = np.full(depth.shape, -1, dtype=np.int64)
    picture = DepthImage(np.zeros(depth.shape, dtype=np.int64), depth, np.zeros(2), 0.002)
    return SideRelief(picture, depth, depth, blob, (), none, none)


def fallen(planes: tuple[float, ...], rows: tuple[int, int] = (0, 100)) -> tuple[SideRelief, list[FrontRectangle]]:
    """A front of strips that lie so deep, and the rectangles that it falls into."""
    depth = np.zeros((100, 200))
    for (a, b), plane in zip(COLUMNS, planes, strict=True):
        depth[:, a:b] = plane
    return relief_of(depth), [FrontRectangle(rows, c, p) for c, p in zip(COLUMNS, planes, strict=True)]


def test_the_stairs_of_a_bulge_are_one_front() -> None:
    side, leaves = fallen((0.012, 0.006, 0.0, 0.006, 0.012))
    (one,) = merge_stairs(side, leaves)
    assert (one.rows, one.columns) == ((0, 100), (0, 200))
    assert one.plane == pytest.approx(0.0)


def test_what_is_no_bulge_stays_apart(subtests: pytest.Subtests) -> None:
    for planes in [
        (0.006, 0.0, 0.006, 0.0, 0.006),  # it rises again
        (0.06, 0.03, 0.0, 0.03, 0.06),  # steps, and no stairs
        (0.0, 0.006, 0.0, 0.006, 0.0),  # a panel in a frame
        (0.024, 0.018, 0.0, 0.0, 0.0),  # it goes down to one side only
    ]:
        with subtests.test(planes=planes):
            side, leaves = fallen(planes)
            assert merge_stairs(side, leaves) == leaves


def measured(parts: list[Part]) -> MeasuredFragments:
    """The pieces of some parts, up z, front -y, a diagonal of 1."""
    placed, _ = in_its_frame(*together(*parts)[:2])
    return measure_fragments(placed, placed.fragment_labels)


def wedge(low: tuple[float, float, float], high: tuple[float, float, float], back: float) -> Part:
    """A box of which the front falls back to both sides by `back` from its middle."""
    points, faces = box(low, high)
    points[[0, 1, 4, 5], 1] += back
    ridge = np.array([[(low[0] + high[0]) / 2, low[1], z] for z in (low[2], high[2])])
    corners = np.concatenate([points, ridge])
    kept = [f for f in faces.tolist() if not set(f) <= {0, 1, 4, 5}]
    more = [(0, 8, 9), (0, 9, 4), (8, 1, 5), (8, 5, 9), (0, 1, 8), (4, 9, 5)]
    return corners, np.array([*kept, *more], dtype=np.int64)


@pytest.mark.parametrize("stands", [0.03, 0.004])
def test_a_stout_bar_at_the_edge_of_a_bulging_front_is_no_part_of_its_leaf(stands: float) -> None:
    """It stands out of what is round it, though not far before the middle of the front; a rail does not."""
    front = wedge((0.0, 0.0, 0.0), (0.6, 0.06, 1.0), 0.02)
    bar = box((0.03, 0.018 - stands, 0.4), (0.08, 0.02, 0.6))
    pieces = measured([box((0.0, 0.06, 0.0), (0.6, 0.6, 1.0)), front, bar])
    (panel,) = [p for p in find_panels(pieces) if len(p.members) > 0 and p.width > 0.4]
    assert (len(panel.members) > 1) is (stands < 0.01)
