"""Each AST and VIS code: silent on what is right, and alone in speaking where one thing is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.checks.package import Package
from casa_assets.checks.run import run
from casa_assets.checks.table.table import TABLE
from casa_assets.model.asset.asset import Asset, Collider, State
from casa_assets.model.asset.parts import Sphere
from casa_assets.model.issue import Report, Status
from tests.support.asset.asset_parts import box_inertial
from tests.support.asset.assets import ball, category, microwave, textured_box
from tests.support.asset.box_assets import (
    as_dense_as,
    balanced_at,
    cornered,
    dented,
    finer_ball,
    gapped,
    half_turned,
    licensed,
    lined,
    linked,
    opened,
    opening,
    pictured,
    plain_box,
    plugged,
    short_by,
    shown,
    side,
    sliced,
    spread_over,
    touched,
    turned,
    with_fin,
    with_sliver,
)
from tests.support.asset.packages import written

ROWS = {check.code: check for check in TABLE if check.code.startswith(("AST", "VIS"))}
LIMITS = registry.load().limits
Build = Callable[[], Asset]

# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Build, Build]] = {
    "AST001": (lambda: plain_box((4.9, 1.0, 1.0)), lambda: plain_box((5.1, 1.0, 1.0))),
    "AST002": (lambda: plain_box((0.2, 0.1, 0.0006)), lambda: plain_box((0.2, 0.1, 0.0004))),
    "AST003": (lambda: as_dense_as(19.0), lambda: as_dense_as(21.0)),
    "AST004": (lambda: as_dense_as(0.06), lambda: as_dense_as(0.04)),
    "AST005": (lambda: sliced(32), lambda: sliced(33)),
    "AST006": (lambda: cornered(64), lambda: cornered(72)),
    "AST007": (lambda: dented(0.0), lambda: dented(2e-5)),
    "AST008": (lambda: balanced_at(0.099), lambda: balanced_at(0.101)),
    "AST009": (lambda: short_by(0.0039), lambda: short_by(0.0041)),
    "AST010": (lambda: plain_box(up=0.0009), lambda: plain_box(up=0.0011)),
    "AST011": (lambda: licensed("CC0-1.0"), lambda: licensed("unknown")),
    "AST012": (plain_box, touched),
    "AST013": (lambda: plain_box((0.3, 0.3, 0.3), 60.0), lambda: plain_box((0.3, 0.3, 0.3), 80.0)),
    "AST014": (lambda: plain_box((1.1, 0.3, 0.3), 20.0), lambda: plain_box((1.3, 0.3, 0.3), 20.0)),
    "AST015": (lambda: opening(0.0, 1.5, True), lambda: opening(-1.5, 1.5, True)),
    "AST016": (lambda: gapped(0.002), lambda: gapped(0.1)),
    "AST018": (lambda: plugged(0.02), lambda: plugged(0.04)),
    "VIS001": (textured_box, with_sliver),
    "VIS002": (lambda: shown(side()), lambda: shown(turned(side(), faces=False))),
    "VIS003": (lambda: lined(0.01), half_turned),
    "VIS004": (lambda: finer_ball(600), lambda: finer_ball(700)),
    "VIS005": (lambda: pictured(4), lambda: pictured(4, unwrapped=False)),
    "VIS006": (lambda: pictured(2048), lambda: pictured(2049)),
    "VIS007": (lambda: with_fin(4), lambda: with_fin(3)),
    "VIS008": (lambda: shown(side(1), side(2)), lambda: shown(side(), side())),
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
class TestExamples:
    def test_good_is_silent(self, code: str, tmp_path: Path) -> None:
        """On every row of the subject, not on this one alone."""
        good = EXAMPLES[code][0]()
        assert judged(good).issues == ()
        subject = good if ROWS[code].subject is Asset else written(good, tmp_path)
        assert run(subject, good.id, LIMITS).issues == ()

    def test_bad_trips_its_code_alone(self, code: str) -> None:
        report = judged_as(code, EXAMPLES[code][1]())
        assert {(issue.code, issue.severity) for issue in report.issues} == {(code, ROWS[code].severity)}
        assert [result.code for result in report.results if result.status is Status.FAILED] == [code]

    def test_limit_parts_the_numbers(self, code: str) -> None:
        limit = ROWS[code].limit
        if limit is None:
            return
        found = [{r.code: r.number for r in judged_as(code, make()).results}[code] for make in EXAMPLES[code]]
        low, high = sorted(number for number in found if number is not None)
        assert low <= LIMITS[limit] <= high
        assert low < high


# Code -> a second way to trip it alone.
ALSO_BAD: list[tuple[str, Build]] = [
    ("AST007", opened),
    ("AST008", lambda: spread_over(0.21)),
    ("AST009", lambda: short_by(0.05, (2.0, 1.0, 1.0))),
    ("AST011", lambda: licensed("")),
    ("AST015", lambda: opening(0.1, 1.5, False)),
    ("VIS002", lambda: shown(side().replace(normals=2 * np.asarray(side().normals)))),
    ("VIS003", lambda: shown(turned(side()))),
    ("VIS005", lambda: pictured(4).replace(links=(shown(side().replace(uv=0 * np.asarray(side().uv))).root,))),
    ("VIS006", lambda: pictured(64, stated_px=32)),
    ("VIS008", lambda: shown(side(), side().replace(faces=np.roll(side().faces[::-1], 1, axis=1)))),
]


def test_other_ways_to_be_wrong(subtests: pytest.Subtests) -> None:
    for code, make in ALSO_BAD:
        with subtests.test(code=code, make=make):
            assert codes(make()) == {code}


# What looks odd and is right.
ALSO_GOOD: list[Build] = [
    lambda: short_by(0.035, (2.0, 1.0, 1.0)),
    lambda: spread_over(0.19),
    lambda: opening(-1.5, 0.0, True),
    lambda: opening(-1.5, 1.5, False),
    lambda: shown(side().replace(normals=None)),
    lambda: shown(side(), turned(side())),  # seen from both sides
    ball,
    textured_box,
    microwave,
]


def test_right_though_odd(subtests: pytest.Subtests) -> None:
    for make in ALSO_GOOD:
        with subtests.test(make=make):
            assert codes(make()) == set()


def test_every_link_is_looked_at() -> None:
    oven = microwave()
    door = oven.link("door").replace(inertial=box_inertial(80.0, (0.38, 0.02, 0.28), (0.19, -0.01, 0.0)))
    (issue,) = judged(oven.replace(links=(oven.root, door))).issues
    assert (issue.code, issue.pointer) == ("AST003", "links/door/inertial")


def test_a_state_asks_for_an_end_at_zero() -> None:
    knob = opening(-1.5, 1.5, False)
    stated = knob.replace(states=(State(name="on", joint="microjoint", value="on", interval=(0.5, 1.0)),))
    assert (codes(knob), codes(stated)) == (set(), {"AST015"})


def test_what_is_neither_seen_nor_touched_does_not_stop_the_checks() -> None:
    nothing = linked(visuals=(), colliders=())
    assert judged_as("AST014", nothing).issues == ()
    ghost = linked(visuals=(), colliders=(Collider(name="ball", shape=Sphere(radius=0.1), substance="cardboard"),))
    assert "AST009" not in codes(ghost)
