"""Things that run through each other are told from things that touch, that lie inside, and that have a handle."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.geometry.mesh.topology import weld
from casa_assets.ingest.repair.components import intersecting_components
from casa_assets.model.asset.parts import Mesh
from tests.meshes import box_mesh
from tests.raw_models import MUG, joined, moved, turned

CUP = turned(MUG, 24)
BOX = box_mesh((0.1, 0.1, 0.1), (0, 0, 0), shared=True)


def message(mesh: Mesh) -> list[str]:
    """Codes of what is said of a mesh."""
    points, place = weld(np.array(mesh.vertices))
    return [note.code for note in intersecting_components(points, place[np.array(mesh.faces)])]


def test_two_mugs_that_run_through_each_other() -> None:
    assert message(joined(CUP, moved(CUP, (0.03, 0.01, 0.0)))) == ["MSH050"]


def test_what_is_no_crossing(subtests: pytest.Subtests) -> None:
    for mesh in [
        CUP,
        joined(CUP, moved(CUP, (0.5, 0.0, 0.0))),
        joined(BOX, moved(BOX, (0.1, 0.0, 0.0))),
        joined(BOX, moved(BOX, scale=0.9)),
        joined(CUP, moved(BOX, (0.05, 0.0, 0.05), 0.3)),
    ]:
        with subtests.test(mesh=mesh):
            assert message(mesh) == []
