"""Each FLT code: silent on what is right, and speaking where one thing is wrong with a mesh of an unknown author."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.checks.filters.kind import misfit
from casa_assets.checks.library import LibrarySizes
from casa_assets.checks.package import Package
from casa_assets.checks.run import run
from casa_assets.checks.table.table import TABLE
from casa_assets.formats.mjcf import write
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material
from casa_assets.model.issue import Report
from casa_assets.model.registry.category import Affordance, Category, MatterFill, RestingPose
from tests.support.asset.asset_parts import box_inertial
from tests.support.asset.assets import write_to
from tests.support.asset.box_assets import plain_box
from tests.support.hostile.untrusted_inputs import (
    BROWN,
    SIZE,
    blurred,
    carton,
    checkers,
    crossed_cards,
    cup,
    held,
    kind_of,
    loose,
    mixed,
    painted,
    with_hole,
    without_side,
)

ROWS = {check.code: check for check in TABLE if check.code.startswith("FLT") or check.code == "LIB004"}
LIMITS = registry.load().limits
Made = tuple[Asset, Category]
Build_ = Callable[[], Made | LibrarySizes]


def usual(asset: Asset) -> Made:
    return asset, kind_of(asset)


def on_a_slab(width: float) -> Made:
    slab = carton((width, width, 0.003))
    body = carton(SIZE, (0.0, 0.0, 0.003 + SIZE[2] / 2))
    boxes = ((SIZE, (0.0, 0.0, 0.06)), ((width, width, 0.003), (0.0, 0.0, 0.0015)))
    asset = loose(body, slab, boxes=boxes, inertial=box_inertial(0.1, (0.08, 0.08, 0.12), (0.0, 0.0, 0.05)))
    return asset, kind_of(asset, (SIZE[0], SIZE[1], SIZE[2]))


def vessel(profile: list[tuple[float, float]] | None = None) -> Made:
    walls = [((0.08, 0.006, 0.09), (0.0, side * 0.037, 0.045)) for side in (-1, 1)]
    ends = [((0.006, 0.068, 0.09), (side * 0.037, 0.0, 0.045)) for side in (-1, 1)]
    floor = ((0.068, 0.068, 0.006), (0.0, 0.0, 0.003))
    mass = box_inertial(0.2, (0.08, 0.08, 0.09), (0.0, 0.0, 0.045))
    asset = loose(cup(profile), boxes=(*walls, *ends, floor), inertial=mass, kind="cup")  # type: ignore[arg-type]
    return asset, kind_of(asset, (0.08, 0.08, 0.09), MatterFill.VESSEL, affords=(Affordance.CONTAINER,))


def parted(gap: float) -> Made:
    half = (0.06, 0.06, (0.12 - gap) / 2)
    low, high = (0.0, 0.0, half[2] / 2), (0.0, 0.0, 0.12 - half[2] / 2)
    return usual(loose(carton(half, low), carton(half, high)))


def turning(factor: float) -> Made:
    one = box_inertial(0.1, SIZE, (0.0, 0.0, 0.06))
    return usual(loose(carton(), inertial=one.replace(inertia=tuple(factor * v for v in one.inertia))))


def standing(lean: float) -> Made:
    """Its balance is `lean` beside its middle."""
    return usual(loose(carton(), inertial=box_inertial(0.1, SIZE, (lean, 0.0, 0.06))))


def heap(top: tuple[float, float, float]) -> Made:
    """A box with another on top, flush to the right, which is what the next one has to stand on."""
    boxes = (((0.06, 0.06, 0.1), (0.0, 0.0, 0.05)), (top, (0.03 - top[0] / 2, 0.0, 0.1 + top[2] / 2)))
    asset = loose(*(carton(size, at) for size, at in boxes), boxes=boxes)
    return asset, kind_of(asset, (0.06, 0.06, 0.1 + top[2]), affords=(Affordance.STACKABLE,))


def graspable(width: float, wide: float) -> Made:
    size = (wide, wide, 0.12)
    asset = loose(carton(size), boxes=((size, (0.0, 0.0, 0.06)),), sites=(held(width),) if width else ())
    return asset, kind_of(asset, size, affords=(Affordance.GRASPABLE,))


def plain(color: tuple[float, float, float, float]) -> Made:
    return usual(loose(carton(), look=Material(id="print", base_color=color, substance="cardboard")))


def shaped(height: float) -> Made:
    size = (0.06, 0.06, height)
    return loose(carton(size), boxes=((size, (0.0, 0.0, height / 2)),)), kind_of(loose(carton()))


def shelf(*longest: float) -> LibrarySizes:
    return LibrarySizes(tuple((f"mug_{i}", "mug", size) for i, size in enumerate(longest)))


def walking(speed: float) -> Made:
    """The good one rests; the bad one is told apart by the scene that it is put into, see `told`."""
    size = (0.12, 0.12, 0.06)
    asset = loose(carton(size), boxes=((size, (0.0, 0.0, 0.03)),), kind="walker" if speed else "carton")
    return asset, kind_of(asset, size, upright=RestingPose.LIES)


def large() -> Made:
    return usual(painted(np.tile(checkers(64, 8), (64, 64, 1))))


# Code -> what it is silent on, and what trips it.
EXAMPLES: dict[str, tuple[Build_, Build_]] = {
    "FLT001": (lambda: usual(loose(carton())), lambda: usual(loose(with_hole(0.04)))),
    "FLT002": (lambda: usual(loose(carton())), lambda: usual(loose(without_side(carton(), (0, 0, -1))))),
    "FLT003": (lambda: usual(loose(carton())), lambda: usual(loose(mixed()))),
    "FLT004": (lambda: usual(loose(carton())), lambda: usual(loose(*crossed_cards()))),
    "FLT005": (lambda: parted(0.001), lambda: parted(0.03)),
    "FLT006": (lambda: on_a_slab(0.07), lambda: on_a_slab(0.2)),
    "FLT007": (lambda: usual(loose(carton())), lambda: usual(loose(carton(), kind="object"))),
    "FLT008": (lambda: shaped(0.14), lambda: shaped(0.36)),
    "FLT009": (vessel, lambda: vessel([(0.0, 0.09), (0.04, 0.09), (0.04, 0.0), (0.0, 0.0)])),
    "FLT010": (lambda: plain(BROWN), lambda: plain((0.004, 0.0, 0.0, 1.0))),
    "FLT011": (lambda: plain((0.5, 0.4, 0.5, 1.0)), lambda: plain((0.5, 0.5, 0.5, 1.0))),
    "FLT012": (lambda: usual(painted(checkers(64, 8))), lambda: usual(painted(checkers(8, 8)))),
    "FLT013": (lambda: usual(painted(checkers(64, 8))), large),
    "FLT014": (lambda: turning(0.5), lambda: turning(0.2)),
    "FLT015": (lambda: walking(0.0), lambda: walking(1.0)),
    "FLT016": (lambda: standing(0.02), lambda: standing(0.035)),
    "FLT017": (lambda: heap((0.05, 0.05, 0.02)), lambda: heap((0.01, 0.01, 0.02))),
    "FLT018": (lambda: graspable(0.06, 0.06), lambda: graspable(0.0, 0.1)),
    "LIB004": (lambda: shelf(0.1, 0.11, 0.12, 0.13, 0.15), lambda: shelf(0.1, 0.11, 0.12, 0.13, 0.3)),
}


def told(made: Made | LibrarySizes, folder: Path) -> Report:
    """What the filters say of a library, or of an asset that is written to a folder."""
    if isinstance(made, LibrarySizes):
        return run(made, "library", LIMITS, table=ROWS.values())
    asset, category = made
    root = write_to(write(asset), folder / asset.digest[:12])
    if asset.id.startswith("walker"):
        scene = root / "scene.xml"
        tilted = scene.read_text().replace('integrator="implicitfast"', 'integrator="implicitfast" gravity="7 0 -9.81"')
        scene.write_text(tilted)
    whole = run(asset, asset.id, LIMITS, table=ROWS.values())
    return whole + run(Package(asset, category, root), asset.id, LIMITS, table=ROWS.values())


@pytest.fixture(scope="module", params=EXAMPLES)
def judged(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Report, Report]:
    """A code with the reports on its good and its bad example."""
    folder = tmp_path_factory.mktemp("filters")
    good, bad = (told(make(), folder) for make in EXAMPLES[request.param])
    return request.param, good, bad


class TestExamples:
    def test_good_is_silent(self, judged: tuple[str, Report, Report]) -> None:
        assert judged[1].issues == ()

    def test_bad_trips_its_code(self, judged: tuple[str, Report, Report]) -> None:
        code, _, bad = judged
        assert (code, ROWS[code].severity) in {(i.code, i.severity) for i in bad.issues}
        assert {i.code for i in bad.issues} <= {code, *ALONG.get(code, ())}

    def test_limit_parts_the_numbers(self, judged: tuple[str, Report, Report]) -> None:
        code, *reports = judged
        limit = ROWS[code].limit
        numbers = [{r.code: r.number for r in report.results}[code] for report in reports]
        if limit is None or None in numbers or code == "FLT018":  # without any grasp there is no width to compare
            return
        low, high = sorted(number for number in numbers if number is not None)
        assert low <= LIMITS[limit] <= high
        assert low < high


# What else is said of a bad example: a side that is missing is seen through as well.
ALONG = {
    "FLT002": ("FLT001",),
    "FLT003": ("FLT001", "FLT002"),
    "FLT006": ("FLT008",),
}


def test_what_was_built_here_is_not_filtered(tmp_path: Path) -> None:
    asset = plain_box()
    found = told((asset, kind_of(asset)), tmp_path)
    assert found.issues == ()
    assert {r.number for r in found.results} == {None}


def test_of_four_none_is_odd() -> None:
    assert run(shelf(0.1, 0.1, 0.1, 0.5), "library", LIMITS).issues == ()


class TestMisfit:
    def test_level_sides_may_be_swapped_and_upright_ones_not(self) -> None:
        row = kind_of(loose(carton()), (0.02, 0.06, 0.12))
        assert misfit(np.array([0.06, 0.02, 0.12]), row) == 1
        assert misfit(np.array([0.12, 0.06, 0.02]), row) > 1.5

    def test_what_has_no_pose_may_lie_any_way(self) -> None:
        row = kind_of(loose(carton()), (0.02, 0.06, 0.12), upright=RestingPose.ANY)
        assert misfit(np.array([0.12, 0.06, 0.02]), row) == 1


class TestPictures:
    def test_a_blurred_picture_is_as_bad_as_a_small_one(self, tmp_path: Path) -> None:
        found = told(usual(painted(blurred(256, 2))), tmp_path)
        assert {i.code for i in found.issues} == {"FLT012"}
        assert "is blurred" in found.issues[0].message

    def test_a_plain_picture_is_none(self, tmp_path: Path) -> None:
        assert told(usual(painted(np.full((4, 4, 3), (200, 40, 40), dtype=np.uint8))), tmp_path).issues == ()

    def test_bare_metal_may_be_grey(self, tmp_path: Path) -> None:
        steel = Material(id="print", base_color=(0.5, 0.5, 0.5, 1.0), metallic=1.0, substance="cardboard")
        assert told(usual(loose(carton(), look=steel)), tmp_path).issues == ()


def test_a_shell_of_a_vessel_is_seen_through_but_kept(tmp_path: Path) -> None:
    """Only what is full must not be hollow."""
    bare = [(0.04, 0.09), (0.04, 0.0), (0.0, 0.0)]
    codes = {i.code for i in told(vessel(bare), tmp_path).issues}
    assert "FLT001" in codes
    assert "FLT002" not in codes


def test_a_wide_thing_with_a_rim_can_be_taken(tmp_path: Path) -> None:
    assert told(graspable(0.005, 0.2), tmp_path).issues == ()
