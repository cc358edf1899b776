"""Open rooms in collision shapes: tubes and lattices keep theirs, and what cannot is a question to a person."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.components import Budget, DecompositionFailed
from casa_assets.ingest.collision.fit import CollideParams
from casa_assets.ingest.collision.solid_proxy import without_windows
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import REVIEW_CODE
from tests.support.mesh.raw_models import category, draft, joined, turned
from tests.support.mesh.solids import box

pytestmark = pytest.mark.content("code", "ingest.collision", keep=0)

PARAMS = CollideParams()
# Radius and height along the wall of a vase that is open at both ends.
TUBE = [(0.05, 0.0), (0.08, 0.1), (0.04, 0.2), (0.036, 0.2), (0.076, 0.1), (0.046, 0.0)]


def no_answer(method: str, points: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    raise DecompositionFailed(f"{method} is not there")


def bars(count: int, side: float, thick: float) -> Mesh:
    """Upright bars in a square grid."""
    places = np.linspace(-side / 2, side / 2, count)
    return joined(*(box((thick, thick, side), (float(x), float(y), side / 2)) for x in places for y in places))


def grating(count: int, side: float, thick: float) -> Mesh:
    """Bars that cross in the plane of the floor."""
    places = [float(v) for v in np.linspace(-side / 2, side / 2, count)]
    along = [box((side, thick, thick), (0.0, v, 0.0)) for v in places]
    return joined(*along, *(box((thick, side, thick), (v, 0.0, 0.0)) for v in places))


def test_a_vase_without_a_bottom_stays_open() -> None:
    ring = turned([*TUBE, TUBE[0]], 32)
    out = collide(draft(ring), category("object"), PARAMS, no_answer)
    assert not [n.message for n in out.notes if n.code == REVIEW_CODE]
    middle = np.array([0.0, 0.0, 0.1])
    boxes = [shape_bounds(p.shape, p.pose) for p in out.colliders]
    assert not any((low < middle).all() and (middle < high).all() for low, high in boxes)


def test_windows_that_no_finger_passes_are_closed() -> None:
    mesh = grating(12, 0.3, 0.008)
    proxy = without_windows(mesh.vertices, mesh.faces)
    assert proxy is not None
    # A plate with one flat face above has no hole: its volume is that of the box around it.
    assert proxy.solid.volume() > 0.8 * 0.3 * 0.3 * 0.008
    assert proxy.solid.genus() == 0
