"""Each CON code: silent on what keeps its contract, and alone in speaking where one thing is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.checks.check import run
from casa_assets.checks.runtime import contract
from casa_assets.checks.runtime.contract import axis_of, missing_requirements, opening, regions
from casa_assets.checks.table import TABLE
from casa_assets.model.asset.asset import Asset, JointKind, Keyframe, Region
from casa_assets.model.pose import Pose
from casa_assets.model.registry.contract import (
    Alternatives,
    Contract,
    OpeningSide,
    PlaceRule,
    RegionRule,
    Requirements,
    Threshold,
)
from tests.support.asset.assets import microwave, rigid_mug
from tests.support.asset.contract_fixtures import hob, oven, packed

ROWS = [check for check in TABLE if check.code.startswith(("CON", "BEH"))]
KNOWN = registry.load()
Make = Callable[[], Asset]


def codes(asset: Asset, folder: Path, contract: Contract | None = None) -> set[str]:
    package = packed(asset, folder, contract)
    found = [run(s, "subject", KNOWN.limits, table=ROWS) for s in (package.asset, package)]
    return {issue.code for report in found for issue in report.issues}


# What is done to a sound asset, and the code that it trips.


def door(asset: Asset, **changes: object) -> Asset:
    return asset.replace(joints=(asset.joints[0].replace(**changes), *asset.joints[1:]))


def without(asset: Asset, collider: str) -> Asset:
    links = [k.replace(colliders=tuple(c for c in k.colliders if c.name != collider)) for k in asset.links]
    return asset.replace(links=tuple(links))


def relabelled(asset: Asset, label: str | None) -> Asset:
    links = (
        k.replace(visuals=tuple(v.replace(label=label) if v.label == "burner" else v for v in k.visuals))
        for k in asset.links
    )
    return asset.replace(links=tuple(links))


def nested() -> Asset:
    plain = hob()
    knob = plain.link("knob_left")
    between = plain.root.replace(name="panel", parent="object", visuals=(), colliders=())
    return plain.replace(links=(plain.root, between, knob.replace(parent="panel")))


def region(name: str, **changes: object) -> Asset:
    plain = oven()
    return plain.replace(regions=tuple(r.replace(**changes) if r.name == name else r for r in plain.regions))


def shallow() -> Asset:
    """A knob that stops before the burner is high, with poses that it can take."""
    return door(hob().replace(keyframes=(Keyframe(name="closed"), Keyframe(name="on"))), range=(0.0, 1.39))


def ajar_when_open() -> Asset:
    plain = oven()
    half = plain.keyframes[1].joints[0].replace(value=-0.8)
    return plain.replace(keyframes=(plain.keyframes[0], Keyframe(name="open", joints=(half,))))


def with_door_bin() -> Asset:
    """A region on the door, whose frame is at the hinge: a loader that leaves bodies out takes it to be elsewhere."""
    plain = oven()
    box = Region(name="bin", link="door", pose=Pose(position=(0.1, 0.0, 0.0)), size=(0.1, 0.01, 0.1))
    return plain.replace(regions=(*plain.regions, box))


BAD: list[tuple[str, Make]] = [
    ("CON001", lambda: oven().replace(contract="wardrobe")),
    ("CON001", lambda: door(oven(), axis=(0.0, 0.0, -1.0))),
    ("CON002", lambda: hob().replace(sites=hob().sites[:1])),
    ("CON003", lambda: without(oven(), "tray")),
    ("CON003", lambda: relabelled(hob(), "plate")),
    ("CON004", lambda: oven().replace(regions=tuple(r for r in oven().regions if r.name != "tray"))),
    ("CON004", lambda: oven().replace(regions=oven().regions[1:])),
    ("CON004", lambda: region("main", size=(0.4, 0.41, 0.3))),
    ("CON004", lambda: region("main", size=(0.7, 0.41, 0.3))),
    ("CON004", lambda: region("int", size=(0.36, 0.34, 0.4))),
    ("CON006", ajar_when_open),
    ("CON006", lambda: oven().replace(keyframes=oven().keyframes[:1])),
    ("CON008", with_door_bin),
    ("CON008", lambda: region("tray", pose=Pose(position=(-0.04, 0.0, 0.2)))),
]

# Code -> old and new text of model.xml that trips it alone.
TAMPERED: list[tuple[str, Make, str, str]] = [
    ("CON005", oven, '<body name="object" pos="0 0 0"', '<body name="object" pos="0 0 0.1"'),
    ("CON005", oven, '<body name="object"', '<body name="thing"'),
    ("CON005", hob, '<site name="burner_on_left"', '<site name="flame"'),
    ("CON005", hob, '<geom name="reg_main"', '<geom name="main"'),
    ("CON005", hob, '<site name="ext_px"', '<site name="outer_px"'),
    ("CON005", hob, 'range="0 3.14159265"', ""),
    ("CON005", oven, "</mujoco>", "<actuator/></mujoco>"),
]


EXAMPLES: dict[str, tuple[Make, object]] = {
    **{code: (oven, make) for code, make in BAD},
    **{code: (make, (old, new)) for code, make, old, new in TAMPERED},
}


def read_at(rule: PlaceRule, folder: Path) -> list[str]:
    package = packed(oven(), folder)
    assert package.contract is not None
    return [message for _, message in contract.faults(package.mjcf, package.contract.replace(places=(rule,)))]


class TestPlaces:
    """CON008 reads a file as the loader of RoboCasa v1.0 does."""

    def test_heights_are_above_the_floor_of_the_kitchen(self, tmp_path: Path) -> None:
        high = PlaceRule(regions="tray", stands_m=1.0, heights_m=(0.45, 1.5))
        assert read_at(high, tmp_path / "high") == []
        assert "0 regions 'tray'" in read_at(high.replace(stands_m=0.0), tmp_path / "low")[0]

    def test_low_regions_and_those_of_moving_parts_are_no_shelves(self, tmp_path: Path) -> None:
        assert "0 regions" in read_at(PlaceRule(regions="tray", min_height_m=2.0), tmp_path / "tall")[0]
        package = packed(with_door_bin(), tmp_path / "bin")
        assert package.contract is not None
        shelf = package.contract.replace(places=(PlaceRule(regions="bin", fixed=True),))
        told = [message for _, message in contract.faults(package.mjcf, shelf)]
        assert any("takes it for a shelf" in message for message in told)

    def test_sites_beside_object_and_above_a_basin(self, tmp_path: Path) -> None:
        package = packed(hob(), tmp_path)
        assert package.contract is not None
        asked = package.contract.replace(beside=("lid_site",), falls_into={"burner_on_left": "basin"})
        pointers = [pointer for pointer, _ in contract.faults(package.mjcf, asked)]
        assert pointers == ["model.xml/site/lid_site", "model.xml/site/burner_on_left"]
        found = package.contract.replace(beside=("bottom_site",), falls_into={"burner_on_left": "main"})
        assert list(contract.faults(package.mjcf, found)) == []


@pytest.mark.parametrize("make", [oven, hob, rigid_mug, microwave])
def test_good_is_silent_and_every_row_looks_at_what_has_a_contract(make: Make, tmp_path: Path) -> None:
    assert codes(make(), tmp_path) == set()
    if make in (oven, hob):
        numbers = {r.code: r.number for r in run(packed(make(), tmp_path), "x", KNOWN.limits, table=ROWS).results}
        assert [code for code, number in numbers.items() if number is None] == []


class TestBad:
    @pytest.mark.parametrize(("code", "make"), BAD)
    def test_trips_one_code(self, code: str, make: Make, tmp_path: Path) -> None:
        assert codes(make(), tmp_path) == {code}

    @pytest.mark.parametrize(("code", "make", "old", "new"), TAMPERED)
    def test_file_trips_one_code(self, code: str, make: Make, old: str, new: str, tmp_path: Path) -> None:
        package = packed(make(), tmp_path)
        text = package.mjcf.read_text()
        assert old in text
        package.mjcf.write_text(text.replace(old, new, 1))
        rows = [row for row in ROWS if row.code.startswith("CON")]
        assert {i.code for i in run(package, "subject", KNOWN.limits, table=rows).issues} == {code}

    def test_a_knob_that_stops_short(self, tmp_path: Path) -> None:
        """It breaks the range that is asked for, the threshold in it, and what turning it does."""
        assert codes(shallow(), tmp_path) == {"CON001", "CON006", "BEH001", "BEH003"}

    def test_what_is_nested_is_not_where_the_runtime_looks(self, tmp_path: Path) -> None:
        assert codes(nested(), tmp_path / "knob") == {"CON001", "CON005"}
        turned = "burner_left_place_site"
        sites = tuple(s.replace(link="knob_left") if s.name == turned else s for s in hob().sites)
        assert codes(hob().replace(sites=sites), tmp_path / "site") == {"CON002", "CON005"}

    def test_a_threshold_out_of_range(self, tmp_path: Path) -> None:
        far = Threshold(name="burner_full", joint="knob_.*_joint", at=3.2)
        contract = KNOWN.contracts["stovetop"]
        asked = contract.replace(thresholds=(*contract.thresholds, far))
        assert codes(hob(), tmp_path, asked) == {"CON006"}

    def test_faults_are_told_apart(self, tmp_path: Path) -> None:
        package = packed(door(oven().replace(keyframes=()), kind=JointKind.SLIDE, range=(0.0, 0.3)), tmp_path)
        rows = [row for row in ROWS if row.code == "CON001"]
        message = " ".join(i.message for i in run(package, "subject", KNOWN.limits, table=rows).issues)
        assert "is a slide, not a hinge" in message
        assert "should open negative" in message
        assert "travels 0.3" in message


class TestRules:
    """Choices, values in use, and directions, on contracts made for the purpose."""

    def test_the_nearest_choice_is_reported(self) -> None:
        def sink(names: tuple[str, ...]) -> Asset:
            plain = hob()
            return plain.replace(regions=tuple(Region(name=n, size=(0.1, 0.1, 0.1)) for n in names))

        one, two = (
            Requirements(regions=tuple(RegionRule(name=n) for n in ns)) for ns in (("basin",), ("left", "right"))
        )
        asked = Contract(id="sink", title="Sink", one_of=(Alternatives(any_of=(one, two)),))
        found = [missing_requirements(sink(n), asked, regions) for n in (("basin",), ("left", "right"), ("left",))]
        assert found[:2] == [[], []]
        assert [pointer for pointer, _ in found[2]] == ["regions/basin"]
        assert len(missing_requirements(sink(("bowl",)), asked, regions)) == 1

    def test_no_burner_at_all(self, tmp_path: Path) -> None:
        bare = hob().replace(links=hob().links[:1], joints=(), sites=(), behavior=None, keyframes=())
        package = packed(bare, tmp_path)
        issues = run(package, "subject", KNOWN.limits, table=[r for r in ROWS if r.code == "CON001"]).issues
        assert [issue.pointer for issue in issues] == ["contract/for_each/loc"]

    def test_opening_and_axis_in_the_asset_frame(self) -> None:
        plain = hob()
        spans = [(0.0, 1.0), (-1.0, 0.0), (-1.0, 2.0), (0.5, 1.0)]
        ways = [OpeningSide.POSITIVE, OpeningSide.NEGATIVE, OpeningSide.BOTH, None]
        assert [opening(plain.joints[0].replace(range=span)) for span in spans] == ways
        turned = Pose(position=(0.0, -0.2, 0.02), quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
        askew = Pose(position=(0.0, -0.2, 0.02), quaternion=(math.cos(0.2), math.sin(0.2), 0.0, 0.0))
        for pose, axis in ((Pose(), "-z"), (turned, "+y"), (askew, "askew")):
            moved = plain.replace(links=(plain.root, plain.links[1].replace(pose=pose)))
            assert axis_of(moved, moved.joints[0]) == axis
