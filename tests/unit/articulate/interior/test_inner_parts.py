"""What slides behind a door: racks do, the floor and the ceiling of the cavity do not."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.interior.inner_parts import _is_lining
from casa_assets.articulate.segment.fragments import measure_fragments
from tests.unit.articulate.blocks import box, carcass, together
from tests.unit.articulate.fragmented import in_its_frame


@pytest.mark.parametrize(("back", "is_lining"), [(0.48, True), (0.44, False)])
def test_a_plate_that_meets_both_sides_and_the_back_is_lining(back: float, is_lining: bool) -> None:
    points, faces, owner = together(*carcass(0.6, 0.5, 0.4), box((0.0205, 0.03, 0.1), (0.5795, back - 0.0005, 0.105)))
    mesh, _ = in_its_frame(points, faces)
    measured = measure_fragments(mesh, mesh.fragment_labels)
    plate = int(mesh.fragment_labels[np.flatnonzero(owner == 5)[0]])
    assert _is_lining(measured, [plate]) is is_lining
