"""What is built in: which inertia is written, and which pairs are left out."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from casa_assets.asset.lightweight import light_scene
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.formats.usd import kitchen as usd
from casa_assets.mesh.inertia import ADJACENT_M, adjacent_links, drop_unfelt_products
from casa_assets.model.asset.asset import Asset, Base, Inertial
from casa_assets.model.kitchen.scene import Scene
from tests.support.asset.cupboard import cupboard, joint_changed
from tests.support.kitchen.rooms import at, block, room
from tests.support.kitchen.scenes import corner

# A tensor about axes that lean by some ten degrees, kg*m^2.
LEANS = Inertial(mass=4.0, center_of_mass=(0.2, -0.01, 0.03), inertia=(0.3, 0.25, 0.2, 0.02, -0.03, 0.01))


def leaning(asset: Asset) -> Asset:
    """The asset with that tensor on every link."""
    return asset.replace(links=tuple(link.replace(inertial=LEANS) for link in asset.links))


def products(asset: Asset) -> dict[str, bool]:
    """Link -> whether its inertia leans."""
    return {link.name: any(link.inertial.inertia[3:]) for link in asset.links}


def resistance(scene: Scene) -> np.ndarray:
    """(nv, nv) inertia against all joints of a scene, those of its assets as they are."""
    model = mujoco.MjModel.from_xml_string(mjcf.write(light_scene(scene)).entries[mjcf.FILE].decode())
    data = mujoco.MjData(model)
    rng = np.random.default_rng(5)
    low, high = model.jnt_range.T
    data.qpos[:] = low + (high - low) * rng.random(model.njnt)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


class TestFelt:
    def test_what_stands_and_what_turns_about_its_own_axis_is_straight(self) -> None:
        assert products(drop_unfelt_products(leaning(cupboard()))) == dict.fromkeys(products(cupboard()), False)

    def test_an_axis_that_leans_itself_keeps_the_tensor(self) -> None:
        leant = leaning(joint_changed("knob_turn", axis=(0.0, math.cos(0.2), math.sin(0.2))))
        assert products(drop_unfelt_products(leant)) == {**dict.fromkeys(products(leant), False), "knob": True}

    def test_what_turns_on_what_turns_keeps_the_tensor(self) -> None:
        whole = leaning(cupboard())
        links = tuple(k.replace(parent="door") if k.name == "knob" else k for k in whole.links)
        assert products(drop_unfelt_products(whole.replace(links=links)))["knob"]

    def test_no_joint_can_tell(self) -> None:
        scene = room((leaning(cupboard()), at(0.0, 0.0, 0.0)))
        found = resistance(scene)
        leant = scene.replace(assets=tuple(a if a.id != cupboard().id else leaning(a) for a in scene.assets))
        assert leant != scene
        assert found == pytest.approx(resistance(leant), rel=1e-9, abs=1e-12)
        assert np.linalg.matrix_rank(found) == len(cupboard().joints)


class TestBeside:
    def test_a_cupboard_is_beside_itself_and_what_is_near(self) -> None:
        wide = block("near", (0.6, 0.05, 0.7))
        gap = 0.257 + 0.025  # from the middle of what stands before it to the bar of the drawer
        for more, near in ((ADJACENT_M - 0.001, True), (ADJACENT_M + 0.02, False)):
            scene = room((cupboard(), at(0.0, 0.0, 0.0)), (wide, at(0.0, -gap - more, 0.0)))
            pairs = {(f"{a.placement}/{a.link}", b.placement) for a, b in adjacent_links(scene)}
            assert {p for p in pairs if p[1] == "thing_0"} == {
                (f"thing_0/{joint.child}", "thing_0") for joint in cupboard().joints
            }
            assert (("thing_0/drawer", "thing_1") in pairs) == near

    def test_what_moves_and_what_is_loose_is_tried_with_everything_that_moves(self) -> None:
        pairs = adjacent_links(corner())
        assets = corner().asset_of
        for moving, fixed in pairs:
            assert assets[moving.placement].base is assets[fixed.placement].base is Base.FIXED
            assert assets[fixed.placement].joint_of(fixed.link) is None
        assert {m.placement for m, _ in pairs} == {"oven", "second_oven", "grill", "other_grill", "unit"}

    def test_both_formats_leave_out_these_pairs(self) -> None:
        scene = room((cupboard(), at(0.0, 0.0, 0.0)), (cupboard(), at(0.6, 0.0, 0.0)))
        count = len(adjacent_links(scene))
        assert count > len(cupboard().joints) * 2
        assert mjcf.write(scene).entries[mjcf.FILE].count(b"<exclude ") == count
        layer = usd.write(scene).entries[usd.FILE].decode()
        targets = [line for line in layer.splitlines() if line.strip().startswith("</World/") and "/object>" in line]
        assert layer.count("PhysicsFilteredPairsAPI") == 2 * len(cupboard().joints)
        assert len(targets) + layer.count("physics:filteredPairs = </World/") >= count
