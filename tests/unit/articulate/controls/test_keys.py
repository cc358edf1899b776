"""Round things: which are keys, which are caps of burners; and where a cup stands under a machine without a tray."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.controls.controls import Control
from casa_assets.articulate.controls.levers_and_buttons import drop_burner_caps, find_single_button
from casa_assets.articulate.interior.regions import find_burners
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.segment.fragments import measure_fragments
from casa_assets.model.asset.parts import Mesh
from tests.support.asset.assets import textured_box
from tests.unit.articulate.blocks import Part, box, disc, together
from tests.unit.articulate.fragmented import found_in, in_its_frame


def control(x: float, y: float, wide: float, high: float, round_: bool = True, stands: float = 0.02) -> Control:
    half = np.array([wide, high]) / 2
    low, high_ = np.append(np.array([x, y]) - half, 0.0), np.append(np.array([x, y]) + half, stands)
    return Control([0], low, high_, stands, round_)


def machine(*more: Part) -> tuple[Part, ...]:
    return box((0, 0.1, 0), (0.2, 0.3, 0.25)), box((0, 0, 0.25), (0.2, 0.3, 0.38)), *more


def test_the_one_round_thing_on_a_front_is_a_key_of_what_somebody_calls_a_machine() -> None:
    found, _ = found_in(machine(disc((0.1, -0.015, 0.31), 0.035, 0.015)), "coffee_machine")
    (part,) = found.parts
    assert part.kind is PartKind.BUTTON
    assert part.joint.axis[1] > 0.99
    assert part.confidence < 0.5


def test_two_of_them_are_not_the_one_key() -> None:
    pair = [disc((x, -0.015, 0.31), 0.02, 0.015) for x in (0.05, 0.15)]
    mesh, _ = in_its_frame(*together(*machine(*pair))[:2])
    assert find_single_button(measure_fragments(mesh, mesh.fragment_labels, 256)) is None


def test_what_arms_stand_round_is_a_burner_and_no_knob() -> None:
    cap, knob = control(0.1, 0.1, 0.06, 0.06), control(0.1, -0.2, 0.05, 0.05)
    arms = [
        control(0.1 + x, 0.1 + y, *size, False)
        for x, y, size in (
            (0.05, 0, (0.05, 0.005)),
            (-0.05, 0, (0.05, 0.005)),
            (0, 0.05, (0.005, 0.05)),
            (0, -0.05, (0.005, 0.05)),
        )
    ]
    left = drop_burner_caps([cap, knob], [cap, knob, *arms], [])
    assert len(left) == 1
    assert left[0] is knob


def test_a_small_panel_with_knobs_and_a_lever_is_no_door() -> None:
    parts = [
        box((0, 0, 0), (0.2, 0.15, 0.2)),
        box((0, 0.15, 0), (0.2, 0.3, 0.2)),
        box((0.06, -0.006, 0.05), (0.14, 0, 0.15)),
    ]
    parts += [box((0.08, -0.03, 0.13), (0.12, -0.006, 0.14))]
    parts += [disc((x, -0.016, 0.07), 0.008, 0.01) for x in (0.08, 0.12)]
    found, _ = found_in(parts)
    assert [p.kind for p in found.parts] == [PartKind.KNOB, PartKind.KNOB]


def test_rings_with_nothing_inside_are_burners_at_the_height_of_their_rim() -> None:
    asset = textured_box()
    around = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    rings = []
    for x, y in ((-0.15, -0.1), (0.15, -0.1), (-0.15, 0.1), (0.15, 0.1)):
        flat = np.concatenate([ring * 0.08, ring * 0.075]) + np.array([x, y])
        points = np.column_stack([flat, np.full(48, 0.9)])
        faces = [f for k in range(24) for f in ((k, (k + 1) % 24, 24 + k), ((k + 1) % 24, 24 + (k + 1) % 24, 24 + k))]
        rings.append(asset.root.visuals[0].replace(mesh=Mesh(vertices=points, faces=faces), name=f"ring_{len(rings)}"))
    found = find_burners(asset.replace(links=(asset.root.replace(visuals=tuple(rings)),)))
    assert [b.loc for b in found] == ["front_left", "rear_left", "front_right", "rear_right"]
    assert {b.middle[2] for b in found} == {0.9}
