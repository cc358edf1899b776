"""Each AST and VIS code: silent on what is right, and alone in speaking where one thing is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casa_assets.checks.check import Package, run
from casa_assets.checks.table import TABLE
from casa_assets.model.asset.asset import Asset, Collider, State
from casa_assets.model.asset.parts import Sphere
from casa_assets.model.issue import Report
from tests.support.asset import box_assets as made
from tests.support.asset.asset_parts import box_inertial
from tests.support.asset.assets import ball, category, microwave, textured_box
from tests.support.asset.examples import LIMITS, between, check_examples
from tests.support.asset.packages import written

ROWS = {check.code: check for check in TABLE if check.code.startswith(("AST", "VIS"))}
Build = Callable[[], Asset]
SIDE = made.side()

# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "AST001": between(made.plain_box, (4.9, 1.0, 1.0), (5.1, 1.0, 1.0)),
    "AST002": between(made.plain_box, (0.2, 0.1, 0.0006), (0.2, 0.1, 0.0004)),
    "AST003": between(made.as_dense_as, 19.0, 21.0),
    "AST004": between(made.as_dense_as, 0.06, 0.04),
    "AST005": between(made.sliced, 32, 33),
    "AST006": between(made.cornered, 64, 72),
    "AST007": between(made.dented, 0.0, 2e-5),
    "AST008": between(made.balanced_at, 0.099, 0.101),
    "AST009": between(made.short_by, 0.0039, 0.0041),
    "AST010": (lambda: made.plain_box(up=0.0009), lambda: made.plain_box(up=0.0011)),
    "AST011": between(made.licensed, "CC0-1.0", "unknown"),
    "AST012": (made.plain_box, made.touched),
    "AST013": (lambda: made.plain_box((0.3, 0.3, 0.3), 60.0), lambda: made.plain_box((0.3, 0.3, 0.3), 80.0)),
    "AST014": (lambda: made.plain_box((1.1, 0.3, 0.3), 20.0), lambda: made.plain_box((1.3, 0.3, 0.3), 20.0)),
    "AST015": (lambda: made.opening(0.0, 1.5, True), lambda: made.opening(-1.5, 1.5, True)),
    "AST016": between(made.gapped, 0.002, 0.1),
    "AST018": between(made.plugged, 0.02, 0.04),
    "VIS001": (textured_box, made.with_sliver),
    "VIS002": (lambda: made.shown(SIDE), lambda: made.shown(made.turned(SIDE, faces=False))),
    "VIS003": (lambda: made.lined(0.01), made.half_turned),
    "VIS004": between(made.finer_ball, 600, 700),
    "VIS005": (lambda: made.pictured(4), lambda: made.pictured(4, unwrapped=False)),
    "VIS006": between(made.pictured, 2048, 2049),
    "VIS007": between(made.with_fin, 4, 3),
    "VIS008": (lambda: made.shown(made.side(1), made.side(2)), lambda: made.shown(SIDE, SIDE)),
}


def judged(asset: Asset) -> Report:
    return run(asset, asset.id, LIMITS, table=ROWS.values())


def judged_as(code: str, asset: Asset) -> Report:
    """With the rows that look at packages where the code is one of theirs; they look at no file."""
    package = Package(asset, category(asset), Path("nowhere"))
    whole = judged(asset)
    return whole + run(package, asset.id, LIMITS, table=ROWS.values()) if ROWS[code].subject is Package else whole


def codes(asset: Asset) -> set[str]:
    return {issue.code for issue in judged(asset).issues}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str, tmp_path: Path) -> None:
    """The good one is silent on every row of its subject, files included."""
    good, bad = (make() for make in EXAMPLES[code])
    check_examples(code, judged_as(code, good), judged_as(code, bad), parted=True)
    subject = good if ROWS[code].subject is Asset else written(good, tmp_path)
    assert run(subject, good.id, LIMITS).issues == ()


# Code -> a second way to trip it alone; without one what looks odd and is right.
ALSO: list[tuple[str, Build]] = [
    ("AST007", made.opened),
    ("AST008", lambda: made.spread_over(0.21)),
    ("AST009", lambda: made.short_by(0.05, (2.0, 1.0, 1.0))),
    ("AST011", lambda: made.licensed("")),
    ("AST015", lambda: made.opening(0.1, 1.5, False)),
    ("VIS002", lambda: made.shown(SIDE.replace(normals=2 * np.asarray(SIDE.normals)))),
    ("VIS003", lambda: made.shown(made.turned(SIDE))),
    ("VIS005", lambda: made.pictured(4).replace(links=made.shown(SIDE.replace(uv=0 * np.asarray(SIDE.uv))).links)),
    ("VIS006", lambda: made.pictured(64, stated_px=32)),
    ("VIS008", lambda: made.shown(SIDE, SIDE.replace(faces=np.roll(SIDE.faces[::-1], 1, axis=1)))),
    ("", lambda: made.short_by(0.035, (2.0, 1.0, 1.0))),
    ("", lambda: made.spread_over(0.19)),
    ("", lambda: made.opening(-1.5, 0.0, True)),
    ("", lambda: made.opening(-1.5, 1.5, False)),
    ("", lambda: made.shown(SIDE.replace(normals=None))),
    ("", lambda: made.shown(SIDE, made.turned(SIDE))),  # seen from both sides
    *(("", make) for make in (ball, textured_box, microwave)),
]


def test_other_ways_to_be_wrong_and_what_is_right_though_odd(subtests: pytest.Subtests) -> None:
    for code, make in ALSO:
        with subtests.test(code=code, make=make):
            assert codes(make()) == ({code} if code else set())


def test_every_link_is_looked_at_and_a_state_asks_for_an_end_at_zero() -> None:
    oven = microwave()
    door = oven.link("door").replace(inertial=box_inertial(80.0, (0.38, 0.02, 0.28), (0.19, -0.01, 0.0)))
    (issue,) = judged(oven.replace(links=(oven.root, door))).issues
    assert (issue.code, issue.pointer) == ("AST003", "links/door/inertial")
    knob = made.opening(-1.5, 1.5, False)
    stated = knob.replace(states=(State(name="on", joint="microjoint", value="on", interval=(0.5, 1.0)),))
    assert (codes(knob), codes(stated)) == (set(), {"AST015"})


def test_what_is_neither_seen_nor_touched_does_not_stop_the_checks() -> None:
    nothing = made.linked(visuals=(), colliders=())
    assert judged_as("AST014", nothing).issues == ()
    ghost = made.linked(visuals=(), colliders=(Collider(name="ball", shape=Sphere(radius=0.1), substance="cardboard"),))
    assert "AST009" not in codes(ghost)
