"""Checks of the form of what is built: its mass, its interiors, and how it looks."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casa_assets.checks.asset import visual
from casa_assets.checks.check import run
from casa_assets.model.asset.asset import Asset
from casa_assets.model.pose import Pose
from tests.support.asset.cupboard import cupboard, filled_to, link_changed, shape, with_shapes, with_trim
from tests.support.asset.packages import LIMITS, codes, judged, number

Build = Callable[[], Asset]


class TestMatter:
    def test_mass_beside_the_hull(self) -> None:
        """Within the box around a bent thing, but outside its hull."""
        inertial = cupboard().link("door").inertial.replace(center_of_mass=(0.02, -0.05, 0.18))
        asset = link_changed("door", inertial=inertial)
        (issue,) = run(asset, asset.id, LIMITS).issues
        assert (issue.code, issue.pointer) == ("AST017", "links/door/inertial")


class TestInterior:
    def test_a_block_that_hangs_from_the_top(self, tmp_path: Path) -> None:
        (issue,) = judged(filled_to(-0.1), tmp_path).issues
        assert (issue.code, issue.pointer) == ("HOL001", "regions/int")
        assert "does not pass" in issue.message

    def test_a_drawer_that_is_solid(self, tmp_path: Path) -> None:
        solid = with_shapes("drawer", shape("matter", (0.3, 0.2, 0.06), (0.0, -0.02, 0.475)))
        assert [(i.code, i.pointer) for i in judged(solid, tmp_path).issues] == [("HOL001", "regions/drawer_int")]

    def test_a_region_without_a_floor(self, tmp_path: Path) -> None:
        whole = cupboard()
        high = whole.regions[1].replace(pose=Pose(position=(0.0, -0.01, 0.3)), size=(0.54, 0.36, 0.2))
        bad = whole.replace(regions=(whole.regions[0], high, whole.regions[2]))
        (issue,) = judged(bad, tmp_path).issues
        assert (issue.code, issue.pointer) == ("HOL001", "regions/int")
        assert number("HOL001", bad, tmp_path) == pytest.approx(0.18, abs=0.005)

    def test_a_narrow_slot_gets_a_smaller_ball(self, tmp_path: Path) -> None:
        whole = cupboard()
        slot = whole.regions[1].replace(pose=Pose(position=(0.0, -0.01, 0.06)), size=(0.2, 0.03, 0.08))
        walls = tuple(shape(f"w_{i}", (0.2, 0.01, 0.08), (0.0, -0.01 + s * 0.021, 0.06)) for i, s in enumerate((-1, 1)))
        carcass = whole.root.replace(colliders=(*whole.root.colliders, *walls))
        toaster = whole.replace(links=(carcass, *whole.links[1:]), regions=(whole.regions[0], slot, whole.regions[2]))
        assert codes(toaster, tmp_path) == set()


class TestLooks:
    def test_a_picture_without_coordinates(self) -> None:
        panel = cupboard().link("door").visuals[0]
        bare = link_changed("door", visuals=(panel.replace(mesh=panel.mesh.replace(uv=None)),))
        (issue,) = [i for i in run(bare, bare.id, LIMITS).issues if i.code == "VIS009"]
        assert "no texture coordinates" in issue.message

    def test_what_flickers(self, subtests: pytest.Subtests) -> None:
        for build, flickers in [
            (lambda: with_trim(0.0, "oak"), False),  # the same finish without a picture looks the same
            (lambda: with_trim(0.01), False),  # lies on the door: the faces that touch look at each other
            (lambda: with_trim(0.00025), False),
            (lambda: with_trim(0.0001), True),
            (lambda: with_trim(-0.0001), True),
        ]:
            with subtests.test(build=build, flickers=flickers):
                asset = build()
                assert ("VIS010" in {i.code for i in run(asset, asset.id, LIMITS).issues}) == flickers

    def test_flicker_is_found_wherever_it_is(self, subtests: pytest.Subtests) -> None:
        """No place or direction falls between the bins that faces are sorted into."""
        for shift in np.arange(12) * 0.0001:
            for turn in [0.0, 0.3, math.pi / 4]:
                with subtests.test(turn=turn, shift=shift):
                    asset = with_trim(0.0)
                    door = asset.link("door")
                    turned = door.replace(
                        pose=Pose(
                            position=(-0.275, -0.202 + float(shift), 0.205),
                            quaternion=(math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)),
                        )
                    )
                    moved = asset.replace(links=tuple(turned if k.name == "door" else k for k in asset.links))
                    assert visual.coplanar_faces_do_not_overlap(moved, LIMITS["flicker_m2"]).number == pytest.approx(
                        0.4 * 0.02, rel=1e-6
                    )
