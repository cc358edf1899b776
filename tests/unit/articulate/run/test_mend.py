"""What the checks would reject for its collision shapes is mended: shapes fit, doors open wider, a person is asked."""

from __future__ import annotations

from pathlib import Path

import pytest

from casa_assets.articulate.decisions import Decisions, PartDecision
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.run.acceptance import mend
from casa_assets.articulate.run.build import ArticulateRequest, build
from casa_assets.articulate.run.steps import ArticulateOutcome, articulate_one
from casa_assets.model.issue import Decision, Issue, Report, Severity
from casa_assets.model.record import Vec3
from tests.unit.articulate.blocks import Part, box, carcass, microwave, together
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate.run", keep=0)

AXES = {"up": (0.0, 0.0, 1.0), "front": (0.0, -1.0, 0.0)}


def _complaint(code: str, pointer: str) -> Report:
    return Report(subject="a", issues=(Issue(code=code, severity=Severity.ERROR, pointer=pointer, message="m"),))


def test_shapes_that_do_not_fit_are_fitted_anew(tmp_path: Path) -> None:
    built = build(ArticulateRequest(obj(tmp_path / "microwave.obj", *microwave()[:2]), tmp_path, **AXES))
    named = built.with_runtime_names()
    mended = mend(built, named, _complaint("AST009", "links/door/colliders"))
    assert mended is not None
    assert mended.spec.refit == {"door_0"}
    shapes = {link.name: link.colliders for link in built.asset.links}
    assert [k.name for k in mended.asset.links if k.colliders != shapes[k.name]] in (["door_0"], ["object", "door_0"])
    again = mend(mended, mended.with_runtime_names(), _complaint("AST009", "links/door/colliders"))
    assert again is None, "what was fitted anew is not fitted once more"
    assert mend(built, named, _complaint("AST002", "links/door")) is None


def _crossing_drawers() -> list[Part]:
    """Two drawers side by side, and a bar on the left one that reaches before the right one."""
    return [
        *carcass(0.8, 0.5, 0.3),
        box((0.03, -0.02, 0.03), (0.39, 0.0, 0.27)),
        box((0.41, -0.02, 0.03), (0.77, 0.0, 0.27)),
        box((0.03, 0.0, 0.03), (0.39, 0.4, 0.04)),
        box((0.41, 0.0, 0.03), (0.77, 0.4, 0.04)),
        box((0.3, -0.08, 0.12), (0.6, -0.06, 0.18)),
        box((0.3, -0.06, 0.14), (0.32, -0.02, 0.16)),
    ]


# A bar of one drawer before the other; and a post of the body 20 mm before a drawer that is to open by 300 mm.
IN_THE_WAY = (
    (
        _crossing_drawers(),
        {"left": ((-0.38, -0.36, 0.0), (0.21, 0.3, 0.3)), "right": ((0.005, -0.28, 0.0), (0.38, 0.3, 0.3))},
    ),
    (
        [*_crossing_drawers()[:9], box((0.1, -0.08, 0.0), (0.3, -0.06, 0.3))],
        {"left": ((-0.38, -0.26, 0.0), (0.0, 0.3, 0.3))},
    ),
)


@pytest.mark.parametrize(("parts", "boxes"), IN_THE_WAY, ids=["each other", "the body"])
def test_parts_that_run_into_something_are_put_to_a_person(
    tmp_path: Path, parts: list[Part], boxes: dict[str, tuple[Vec3, Vec3]]
) -> None:
    decided = {name: PartDecision(kind=PartKind.DRAWER, box_m=corners, travel_m=0.3) for name, corners in boxes.items()}
    request = ArticulateRequest(
        obj(tmp_path / "cabinet.obj", *together(*parts)[:2]),
        tmp_path / "lib",
        category="base_cabinet",
        size_m=0.8,
        decisions=Decisions(parts=decided),
        complete=False,
        **AXES,
    )
    done = articulate_one(request)
    assert isinstance(done, ArticulateOutcome), done
    assert done.decision is Decision.REVIEW, done.message
    if len(boxes) == 2:
        assert done.to_decide == ("contacts",), done.message
    else:
        assert done.report is not None
        (issue,) = (i for i in done.report.issues if i.pointer == "contacts")
        assert "of its range, then runs into object" in issue.message
