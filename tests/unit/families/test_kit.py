"""The kit: solids are closed and of the right volume, skins true to size, joints start at the force they were given."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from pydantic import ValidationError

from casa_assets.asset.assemble import assemble
from casa_assets.asset.asset_builder import ROOT, AssetBuilder, BehaviorBuilder, negated
from casa_assets.asset.blocks import ball, board, box, lathe, rod
from casa_assets.asset.family import FinishId, Params, Supplies
from casa_assets.asset.solid import Solid, solid_mesh
from casa_assets.asset.sweep import circle, inset_rings, loft, prism, rectangle, slab, tube
from casa_assets.mesh.surface import is_closed
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.behavior import Condition, Rule
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.asset.parts import Box
from casa_assets.model.registry.rows import Finish
from tests.support.asset.asset_parts import labels

WOOD = Substance(id="wood", density=600.0, static_friction=0.5, dynamic_friction=0.4)
TILED = Finish(id="tiled", material=Material(id="tiled", tile_m=(0.5, 0.8)), substance=WOOD)
PLAIN = Finish(id="plain", material=Material(id="plain"), substance=WOOD)
SUPPLIES = Supplies(
    {"tiled": TILED, "plain": PLAIN}, labels("cabinet", ("cabinet", "furniture"), "Q1049754"), {"foam": 100.0}
)

SOLIDS: dict[str, tuple[Solid, float]] = {
    "sharp box": (box((0.2, 0.3, 0.4), edge_radius=0.0), 0.024),
    "board": (board((0.0, 0.0, 0.0), (0.6, 0.018, 0.7), edge_radius=0.0), 0.6 * 0.018 * 0.7),
    "cylinder": (rod(0.05, 0.2, edge_radius=0.0005), math.pi * 0.05**2 * 0.2),
    "ball": (ball(0.05, 24), 4 / 3 * math.pi * 0.05**3),
    "ring": (lathe([(0.04, 0.0), (0.05, 0.0), (0.05, 0.1), (0.04, 0.1)], 64, closed=True), math.pi * 0.0009 * 0.1),
    "plate with a hole": (prism(rectangle(0.4, 0.3), 0.02, 0.0, [rectangle(0.1, 0.1)]), (0.12 - 0.01) * 0.02),
    "slab": (slab(rectangle(0.4, 0.3), [(0.0, 0.0), (0.0, 0.03)], [True] * 4), 0.4 * 0.3 * 0.03),
    "pipe": (tube([(0, 0, 0), (0, 0, 0.3)], 0.01), math.pi * 0.01**2 * 0.3),
    "mitred strap": (tube([(0, 0, 0), (0.2, 0, 0), (0.2, 0, 0.2)], rectangle(0.02, 0.01)), 0.4 * 0.0002),
    "taper": (loft(inset_rings(circle(0.1, 64), [(0.0, 0.0), (0.05, 0.1)])), math.pi * 0.1 / 3 * 0.0175),
}


@pytest.mark.parametrize("name", sorted(SOLIDS))
def test_a_solid_is_closed_of_the_volume_of_the_formula_and_its_skin_true_to_size(name: str) -> None:
    solid, volume = SOLIDS[name]
    assert is_closed(solid.faces)
    assert solid.volume == pytest.approx(volume, rel=0.03)
    for other in (solid.translated(1.0, 2.0, 3.0), solid.rotated("y", 0.7), solid.mirrored_x()):
        assert other.volume == pytest.approx(solid.volume, rel=1e-6)
    mesh = solid_mesh(solid, (0.5, 0.8), (0.0, 0.0, 1.0), name)
    assert mesh.uv is not None
    corners, shown = mesh.vertices[mesh.faces], mesh.uv[mesh.faces] * np.array([0.5, 0.8])
    for i, j in ((0, 1), (1, 2), (2, 0)):
        true = np.linalg.norm(corners[:, i] - corners[:, j], axis=1)
        flat = np.linalg.norm(shown[:, i] - shown[:, j], axis=1)
        # What is laid flat is exact; what is rolled off stretches a little at its seams.
        if solid.uv_m is None:
            np.testing.assert_allclose(flat, true, atol=1e-6)
        else:
            assert np.median(np.abs(flat - true)) < 1e-3


def test_the_collider_of_a_mirrored_part_lies_where_its_mesh_is() -> None:
    """Also one that slants to two sides."""
    solid = box((0.2, 0.3, 0.4), edge_radius=0.0).rotated("y", 0.7).rotated("x", 0.4).translated(0.5).mirrored_x()
    ((shape, at),) = solid.shapes
    assert isinstance(shape, Box)
    corners = at.apply(np.array(list(product((-0.5, 0.5), repeat=3))) * shape.size)
    ways = np.random.default_rng(0).normal(size=(3, 30))
    np.testing.assert_allclose((corners @ ways).max(axis=0), (solid.points @ ways).max(axis=0), atol=1e-6)


class Lid(Params):
    """A board on a hinge."""

    width: float = 0.4
    face: FinishId = "tiled"
    back: FinishId | None = None


def chest(start_n: float = 7.0, left: float = 0.0) -> Asset:
    """A box with a door of 400 mm, pulled at its edge; `left`: x of the hinge in the frame of the door's link."""
    builder = AssetBuilder(SUPPLIES)
    builder.contract = "hinge_cabinet"
    builder.add(ROOT, board((0, 0.02, 0), (0.4, 0.3, 0.6)), "plain", label="case")
    builder.link("door", at=(-left, 0.0, 0.0))
    leaf, pull = board((left, 0, 0), (left + 0.4, 0.018, 0.6)), box((0.01, 0.03, 0.1), (left + 0.36, -0.015, 0.3))
    builder.add("door", leaf, "tiled", label="door", name="door_main")
    builder.add("door", pull, "plain", label="handle", name="door_handle_main")
    span, anchor = (-math.pi / 2, 0.0), (left, 0.0, 0.0)
    builder.hinge("doorhinge", "door", (0, 0, 1), span, "door_handle_main", anchor=anchor, start_n=start_n)
    builder.keyframe("closed")
    builder.keyframe("open", doorhinge=builder.joint_position("doorhinge"))
    return assemble(builder, "chest", Lid())


def test_an_asset_is_what_was_built() -> None:
    asset = chest()
    assert asset.root.inertial.mass == pytest.approx(0.4 * 0.28 * 0.6 * 600.0, rel=0.001)
    low, high = asset.bounds
    assert low[2] == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose((low + high)[:2], 0.0, atol=1e-6)
    (main,) = [r for r in asset.regions if r.name == "main"]
    np.testing.assert_allclose(main.size, high - low, atol=1e-6)
    assert [c.name for c in asset.link("door").colliders] == ["door_main", "door_handle_main"]
    assert asset.digest == chest().digest
    opened = next(k for k in asset.keyframes if k.name == "open")
    assert opened.joints[0].value == pytest.approx(-math.pi / 2)


def test_friction_starts_at_the_given_force_and_a_grip_that_is_not_there_is_refused() -> None:
    for force in (6.0, 12.0):
        (joint,) = chest(force).joints
        assert joint.frictionloss == pytest.approx(force * math.hypot(0.36, 0.015), rel=0.01)
    builder = AssetBuilder(SUPPLIES)
    builder.add(ROOT, box((0.1, 0.1, 0.1)), "plain")
    builder.link("flap")
    builder.add("flap", box((0.1, 0.1, 0.1)), "plain")
    builder.hinge("flap_joint", "flap", (0, 0, 1), (0.0, 1.0), "no_handle")
    with pytest.raises(ValueError, match="no collider 'no_handle'"):
        assemble(builder, "chest", Lid())


def test_a_door_resists_a_hand_alike_wherever_the_frame_of_its_link_lies() -> None:
    (joint,) = chest().joints
    for left in (-0.7, 0.3):
        (moved,) = chest(left=left).joints
        assert (moved.damping, moved.armature) == pytest.approx((joint.damping, joint.armature), rel=0.01)


def test_what_is_hidden_in_a_case_turns_like_a_block_of_its_size_and_mass() -> None:
    size, at = (0.1, 0.2, 0.4), (0.05, 0.1, 0.3)
    found = []
    for is_drawn in (False, True):
        builder = AssetBuilder(SUPPLIES)
        builder.add(ROOT, box((0.5, 0.5, 0.5), (0.0, 0.0, 0.25), edge_radius=0.0), "plain", density=20.0)
        if is_drawn:
            builder.draw(ROOT, box(size, at, edge_radius=0.0), "plain", density=6.0 / math.prod(size))
        else:
            builder.ballast(ROOT, 6.0, at, size)
        found.append(assemble(builder, "chest", Lid()).root.inertial)
    hidden, drawn = found
    assert hidden.mass == pytest.approx(drawn.mass)
    np.testing.assert_allclose(hidden.center_of_mass, drawn.center_of_mass, atol=1e-6)
    np.testing.assert_allclose(hidden.tensor, drawn.tensor, rtol=1e-4, atol=1e-6)


def test_a_state_machine_keeps_its_variables_rules_and_effects_in_order() -> None:
    builder, down = BehaviorBuilder(), Condition(joint="lever", interval=(-1.0, -0.5))
    assert builder.build() is None
    builder.variable("power")
    builder.rule("power", "on", down, before="off", after_s=2.0)
    builder.rule("power", "off", negated(down))
    builder.follow_joint("speed", "knob", {"low": (0.0, 1.0), "high": (1.0, 2.0)})
    builder.light("power", "lamp", (1.0, 0.0, 0.0, 1.0))
    made = builder.build()
    assert made is not None
    power, speed = ("power", ("off", "on"), "off"), ("speed", ("low", "high"), "low")
    assert [(v.name, v.values, v.initial) for v in made.variables] == [power, speed]
    assert made.rules == (
        Rule(variable="power", from_values=("off",), to="on", when=(down,), after_s=2.0),
        Rule(variable="power", to="off", when=(down.replace(negated=True),)),
        Rule(variable="speed", to="low", when=(Condition(joint="knob", interval=(0.0, 1.0)),)),
        Rule(variable="speed", to="high", when=(Condition(joint="knob", interval=(1.0, 2.0)),)),
    )
    assert [(e.variable, e.value, e.target) for e in made.effects] == [("power", "on", "lamp")]
    builder.rule("powr", "on", down)
    with pytest.raises(ValidationError, match="no variable 'powr'"):
        builder.build()
