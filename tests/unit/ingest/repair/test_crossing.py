"""Things that run through each other are told from things that touch, that lie inside, and that have a handle."""

from __future__ import annotations

import pytest

from casa_assets.ingest.components import intersecting_components
from casa_assets.model.asset.parts import Mesh
from tests.support.mesh.raw_models import MUG, codes, joined, moved, turned
from tests.support.mesh.solids import box, welded

CUP = turned(MUG, 24)
BOX = box((0.1, 0.1, 0.1))


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (joined(CUP, moved(CUP, (0.03, 0.01, 0.0))), ["MSH050"]),
        (CUP, []),
        (joined(CUP, moved(CUP, (0.5, 0.0, 0.0))), []),
        (joined(BOX, moved(BOX, (0.1, 0.0, 0.0))), []),
        (joined(BOX, moved(BOX, scale=0.9)), []),
        (joined(CUP, moved(BOX, (0.05, 0.0, 0.05), 0.3)), []),
    ],
)
def test_what_is_said(mesh: Mesh, said: list[str]) -> None:
    assert codes(tuple(intersecting_components(*welded(mesh)))) == said
