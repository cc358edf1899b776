"""The swift form of SimReady's rule of coincident meshes says what the rule itself says."""

from __future__ import annotations

import pytest
from pxr import Gf, Usd, UsdGeom

pytestmark = pytest.mark.consumers

CORNERS = ((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.4, 0.0), (0.0, 0.0, 0.5))
FACES = (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
Vec = tuple[float, float, float]
HERE: Vec = (0.0, 0.0, 0.0)


def stage_of(
    moved: Vec = HERE, off: Vec = HERE, faces: tuple[int, ...] = FACES, turned: float = 0.0, hidden: bool = False
) -> Usd.Stage:
    """Two wedges, the second of them placed, shaped, turned (degrees) or hidden otherwise."""
    stage = Usd.Stage.CreateInMemory()
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    for name, at, by, corners, angle in (("a", HERE, HERE, FACES, 0.0), ("b", moved, off, faces, turned)):
        mesh = UsdGeom.Mesh.Define(stage, f"/World/{name}")
        mesh.CreatePointsAttr([Gf.Vec3f(*(c + o for c, o in zip(corner, by, strict=True))) for corner in CORNERS])
        mesh.CreateFaceVertexCountsAttr([3] * (len(corners) // 3))
        mesh.CreateFaceVertexIndicesAttr(corners)
        mesh.AddTranslateOp().Set(Gf.Vec3d(*at))
        mesh.AddRotateZOp().Set(angle)
    if hidden:
        mesh.MakeInvisible()
    return stage


def verdicts(stage: Usd.Stage) -> tuple[int, int]:
    """How much their rule finds, and ours."""
    from tests.support.asset.simready_rules import registered, simready

    swift = registered(simready.COINCIDENT)
    theirs = swift.__mro__[1]
    assert swift.__name__ == "CoincidentMeshes"
    assert theirs.__module__.startswith("simready.")
    found = []
    for kind in (theirs, swift):
        rule = kind()
        rule.CheckStage(stage)
        found.append(len(rule.GetIssues()))
    return found[0], found[1]


@pytest.mark.parametrize(
    ("stage", "found"),
    [
        pytest.param(stage_of(), 1, id="the-same-twice"),
        pytest.param(stage_of(off=(2e-8, 0.0, 0.0)), 1, id="points-that-round-to-the-same"),
        pytest.param(stage_of(moved=(2e-5, 0.0, 0.0)), 1, id="places-that-round-to-the-same"),
        pytest.param(stage_of(off=(1e-5, 0.0, 0.0)), 0, id="other-points"),
        pytest.param(stage_of(moved=(0.0, 0.0, 0.001)), 0, id="a-millimetre-higher"),
        pytest.param(stage_of(turned=90.0), 0, id="turned"),
        pytest.param(stage_of(faces=FACES[3:] + FACES[:3]), 0, id="faces-in-another-order"),
        pytest.param(stage_of(hidden=True), 0, id="the-other-is-hidden"),
        pytest.param(Usd.Stage.CreateInMemory(), 0, id="nothing-at-all"),
    ],
)
def test_both_find_the_same(stage: Usd.Stage, found: int) -> None:
    assert verdicts(stage) == (found, found)
