"""Each CON code: silent on what keeps its contract, and alone in speaking where one thing is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.checks.package import Package
from casa_assets.checks.run import run
from casa_assets.checks.runtime import loader_places
from casa_assets.checks.runtime.contract import axis_of, missing_requirements, opening, regions
from casa_assets.checks.table.table import TABLE
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
    """Codes of all rows on contracts and behaviours that find a fault."""
    return codes_of(packed(asset, folder, contract))


def codes_of(package: Package) -> set[str]:
    found = [run(s, "subject", KNOWN.limits, table=ROWS) for s in (package.asset, package)]
    return {issue.code for report in found for issue in report.issues}


# What is done to a sound asset, and the code that it trips.


def door(asset: Asset, **changes: object) -> Asset:
    """The first joint changed."""
    return asset.replace(joints=(asset.joints[0].replace(**changes), *asset.joints[1:]))


def without(asset: Asset, collider: str) -> Asset:
    links = [k.replace(colliders=tuple(c for c in k.colliders if c.name != collider)) for k in asset.links]
    return asset.replace(links=tuple(links))


def relabelled(asset: Asset, label: str | None) -> Asset:
    """Every collider and visual that had the label of its handle has another."""
    links = [
        k.replace(
            visuals=tuple(v.replace(label=label) if v.label == "burner" else v for v in k.visuals),
        )
        for k in asset.links
    ]
    return asset.replace(links=tuple(links))


def nested() -> Asset:
    """The knob is carried by a link that is carried by `object`."""
    plain = hob()
    knob = plain.link("knob_left")
    between = plain.root.replace(name="panel", parent="object", visuals=(), colliders=())
    return plain.replace(links=(plain.root, between, knob.replace(parent="panel")))


def region(asset: Asset, name: str, **changes: object) -> Asset:
    return asset.replace(regions=tuple(r.replace(**changes) if r.name == name else r for r in asset.regions))


def hob_site(name: str, **changes: object) -> Asset:
    plain = hob()
    return plain.replace(sites=tuple(s.replace(**changes) if s.name == name else s for s in plain.sites))


def shallow() -> Asset:
    """A knob that stops before the burner is high, with poses that it can take."""
    return door(hob().replace(keyframes=(Keyframe(name="closed"), Keyframe(name="on"))), range=(0.0, 1.39))


def ajar_when_open() -> Asset:
    """The pose `open` stands half open."""
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
    ("CON004", lambda: region(oven(), "main", size=(0.4, 0.41, 0.3))),
    ("CON004", lambda: region(oven(), "main", size=(0.7, 0.41, 0.3))),
    ("CON004", lambda: region(oven(), "int", size=(0.36, 0.34, 0.4))),
    ("CON006", ajar_when_open),
    ("CON006", lambda: oven().replace(keyframes=oven().keyframes[:1])),
    ("CON008", with_door_bin),
    ("CON008", lambda: region(oven(), "tray", pose=Pose(position=(-0.04, 0.0, 0.2)))),
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
    """What is told of the places of the microwave oven where they are asked for by a rule."""
    package = packed(oven(), folder)
    assert package.contract is not None
    return [message for _, message in loader_places.faults(package.mjcf, package.contract.replace(places=(rule,)))]


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
        told = [message for _, message in loader_places.faults(package.mjcf, shelf)]
        assert any("takes it for a shelf" in message for message in told)

    def test_sites_beside_object_and_above_a_basin(self, tmp_path: Path) -> None:
        package = packed(hob(), tmp_path)
        assert package.contract is not None
        asked = package.contract.replace(beside=("lid_site",), falls_into={"burner_on_left": "basin"})
        pointers = [pointer for pointer, _ in loader_places.faults(package.mjcf, asked)]
        assert pointers == ["model.xml/site/lid_site", "model.xml/site/burner_on_left"]
        found = package.contract.replace(beside=("bottom_site",), falls_into={"burner_on_left": "main"})
        assert list(loader_places.faults(package.mjcf, found)) == []


class TestGood:
    @pytest.mark.parametrize("make", [oven, hob, rigid_mug, microwave])
    def test_is_silent(self, make: Make, tmp_path: Path) -> None:
        assert codes(make(), tmp_path) == set()

    @pytest.mark.parametrize("make", [oven, hob])
    def test_every_row_looked(self, make: Make, tmp_path: Path) -> None:
        package = packed(make(), tmp_path)
        numbers = {r.code: r.number for r in run(package, "subject", KNOWN.limits, table=ROWS).results}
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
        place = hob_site("burner_left_place_site", link="knob_left")
        assert codes(place, tmp_path / "site") == {"CON002", "CON005"}

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
        look = regions
        assert missing_requirements(sink(("basin",)), asked, look) == []
        assert missing_requirements(sink(("left", "right")), asked, look) == []
        assert [pointer for pointer, _ in missing_requirements(sink(("left",)), asked, look)] == ["regions/basin"]
        assert len(missing_requirements(sink(("bowl",)), asked, look)) == 1

    def test_no_burner_at_all(self, tmp_path: Path) -> None:
        bare = hob().replace(links=hob().links[:1], joints=(), sites=(), behavior=None, keyframes=())
        package = packed(bare, tmp_path)
        issues = run(package, "subject", KNOWN.limits, table=[r for r in ROWS if r.code == "CON001"]).issues
        assert [issue.pointer for issue in issues] == ["contract/for_each/loc"]

    def test_opening(self, subtests: pytest.Subtests) -> None:
        for span, way in [
            ((0.0, 1.0), OpeningSide.POSITIVE),
            ((-1.0, 0.0), OpeningSide.NEGATIVE),
            ((-1.0, 2.0), OpeningSide.BOTH),
            ((0.5, 1.0), None),
        ]:
            with subtests.test(span=span, way=way):
                assert opening(hob().joints[0].replace(range=span)) is way

    def test_axis_is_told_in_the_asset_frame(self) -> None:
        plain = hob()
        turned = Pose(position=(0.0, -0.2, 0.02), quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
        askew = Pose(position=(0.0, -0.2, 0.02), quaternion=(math.cos(0.2), math.sin(0.2), 0.0, 0.0))
        found = [
            axis_of(a, a.joints[0])
            for pose in (Pose(), turned, askew)
            if (a := plain.replace(links=(plain.root, plain.links[1].replace(pose=pose))))
        ]
        assert found == ["-z", "+y", "askew"]
