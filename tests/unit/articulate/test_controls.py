"""Controls are typed by the group that they stand in; levers in slots; keys, and caps of burners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.articulate.controls.classify import classify_with_dials
from casa_assets.articulate.controls.controls import Control, find_controls, group_controls
from casa_assets.articulate.controls.levers_and_buttons import Lever, find_levers
from casa_assets.articulate.infer import choose_plan
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.runtime_places import find_burners
from casa_assets.articulate.segment.orthographic import FRONT
from casa_assets.core.numeric import forest_from_dict
from casa_assets.model.asset.parts import Mesh
from tests.support.asset.assets import textured_box
from tests.unit.articulate.blocks import Part, box, carcass, disc, together
from tests.unit.articulate.fragmented import in_its_frame, pieces_in


def control(x: float, z: float, width: float, height: float, stands: float = 0.01) -> Control:
    half = np.array([width, height]) / 2
    low, high = np.append(np.array([x, z]) - half, 0.0), np.append(np.array([x, z]) + half, stands)
    return Control([0], low, high, stands, width == height)


def kinds_of(*parts: Part) -> list[PartKind]:
    """The kinds of the knobs and keys that are found on a mesh, as the whole command would type them."""
    mesh, frame = in_its_frame(*together(*parts)[:2])
    found = choose_plan(mesh, frame, "", load_models()).articulation.parts
    return [p.kind for p in found if p.kind in (PartKind.KNOB, PartKind.BUTTON)]


def test_a_grid_is_one_group_and_a_wide_key_below_it_another() -> None:
    grid = [control(0.05 * a, 0.05 * b, 0.03, 0.03) for a in range(3) for b in range(4)]
    groups = group_controls([*grid, control(0.05, -0.06, 0.13, 0.03)])
    assert sorted((len(g.members), g.rows, g.columns) for g in groups) == [(1, 1, 1), (12, 4, 3)]
    assert groups[0].pitch == pytest.approx(0.05 / 0.03)


def test_round_keys_in_a_grid_beside_a_door_are_keys() -> None:
    door, panel = box((0.0, -0.02, 0.0), (0.37, -0.0005, 0.3)), box((0.375, -0.02, 0.0), (0.5, -0.0005, 0.3))
    keys = [disc((0.4 + 0.037 * a, -0.025, 0.08 + 0.032 * b), 0.011, 0.0049, 16) for a in range(3) for b in range(5)]
    bar = box((0.335, -0.05, 0.05), (0.35, -0.0205, 0.25))
    assert kinds_of(*carcass(0.5, 0.38, 0.3), door, panel, bar, *keys) == [PartKind.BUTTON] * 15


def test_octagonal_bosses_in_a_row_over_an_oven_door_are_knobs() -> None:
    door, bar = box((0.0, -0.03, 0.0), (0.6, -0.0005, 0.58)), box((0.06, -0.07, 0.52), (0.54, -0.0305, 0.54))
    panel = box((0.0, -0.03, 0.59), (0.6, -0.0005, 0.7))
    knobs = [disc((0.08 + 0.11 * k, -0.055, 0.645), 0.022, 0.0249, 8) for k in range(5)]
    assert kinds_of(*carcass(0.6, 0.55, 0.7), door, bar, panel, *knobs) == [PartKind.KNOB] * 5


def test_pulls_of_drawers_are_neither() -> None:
    fronts = [box((0.005, -0.02, 0.01 + 0.2 * k), (0.495, -0.0005, 0.195 + 0.2 * k)) for k in range(3)]
    pulls = [disc((0.25, -0.045, 0.1 + 0.2 * k), 0.015, 0.0249, 16) for k in range(3)]
    assert kinds_of(*carcass(0.5, 0.45, 0.61), *fronts, *pulls) == []


def test_a_forest_gives_the_mean_of_its_trees(monkeypatch: pytest.MonkeyPatch) -> None:
    leaf = [[[0, 100]]]
    trees = [[[0, 0.5, 1, 2], [[100, 0]], [[50, 50]]], leaf]
    forest = forest_from_dict({"features": ["a"], "classes": ["x", "y"], "trees": trees})
    assert forest.probabilities(np.array([[0.5], [0.6]])).tolist() == [[0.5, 0.5], [0.25, 0.75]]
    with pytest.raises(ValueError, match="points nowhere"):
        forest_from_dict({"features": ["a"], "classes": ["x", "y"], "trees": [[[0, 0.5, 1, 3], *leaf, *leaf]]})
    monkeypatch.setattr(registry, "learned_forest", lambda _: forest)
    with pytest.raises(ValueError, match="other features"):
        load_models.__wrapped__()


def test_round_things_that_are_smaller_than_the_dial_of_a_toaster_are_its_keys() -> None:
    def classify(_control: Control, _others: Sequence[Control]) -> tuple[PartKind | None, float, str]:
        return PartKind.KNOB, 0.6, "round"

    dial, key, lever = control(0.0, 0.0, 0.06, 0.06), control(0.08, 0.0, 0.04, 0.04), control(0.0, 0.1, 0.058, 0.058)
    told = classify_with_dials(classify)
    assert [told(c, [dial, key, lever])[0] for c in (dial, key, lever)] == [
        PartKind.KNOB,
        PartKind.BUTTON,
        PartKind.KNOB,
    ]


def levers_in(parts: list[Part]) -> tuple[list[Lever], float]:
    """Levers on the front of some parts, and metres in a unit of the frame."""
    pieces = pieces_in(*parts)
    size = float(np.linalg.norm(np.ptp(together(*parts)[0], axis=0)))
    return find_levers(pieces, find_controls(pieces, FRONT, [])), size


def test_a_pad_at_the_end_of_a_slot_is_a_lever_that_goes_along_it() -> None:
    parts = [box((0.0, 0.03, 0.0), (0.3, 0.3, 0.25)), box((0.13, -0.03, 0.18), (0.17, -0.005, 0.19))]
    parts += [box((x, 0.0, 0.0), (x + 0.145, 0.03, 0.25)) for x in (0.0, 0.155)]
    parts += [box((0.145, 0.0, low), (0.155, 0.03, high)) for low, high in ((0.0, 0.06), (0.2, 0.25))]
    (lever,), unit = levers_in(parts)
    assert lever.way == pytest.approx((0, -1, 0), abs=0.02)
    assert lever.length * unit == pytest.approx(0.12, abs=0.01)
    assert (lever.control.upper - lever.control.lower) * unit == pytest.approx((0.04, 0.01, 0.025), abs=1e-6)


def test_a_slot_that_falls_back_in_stairs_has_their_slope() -> None:
    steps = 20
    parts = [box((0.0, 0.06, 0.0), (0.3, 0.3, 0.3))]
    for k in range(steps):
        low, high, y = 0.3 * k / steps, 0.3 * (k + 1) / steps, 0.003 * k
        parts += [box((0.0, y, low), (0.145, 0.06, high)), box((0.155, y, low), (0.3, 0.06, high))]
    parts += [box((0.145, 0.0, 0.0), (0.155, 0.06, 0.06))]
    levers, _ = levers_in([*parts, box((0.13, 0.01, 0.24), (0.17, 0.044, 0.25))])
    lever = max(levers, key=lambda v: float(v.control.middle[1]))
    assert lever.way[2] / lever.way[1] == pytest.approx(0.2, abs=0.05)


def test_a_gap_between_two_fronts_is_no_slot_and_what_has_no_slot_is_no_lever() -> None:
    fronts = [box((0.0, 0.0, z), (0.3, 0.02, z + 0.12)) for z in (0.0, 0.13)]
    beside = [box((x, 0.0, 0.0), (x + 0.145, 0.02, 0.25)) for x in (0.0, 0.155)]
    pad = box((0.13, -0.03, 0.18), (0.17, -0.005, 0.19))
    assert levers_in([box((0.0, 0.05, 0.0), (0.3, 0.3, 0.25)), *fronts, pad])[0] == []
    assert levers_in([box((0.0, 0.05, 0.0), (0.3, 0.3, 0.25)), *beside, pad])[0] == []
    assert levers_in([box((0.0, 0.0, 0.0), (0.2, 0.3, 0.25)), box((0.07, -0.02, 0.05), (0.13, -1e-4, 0.08))])[0] == []


def test_a_sheet_that_a_knob_stands_on_stays() -> None:
    corners = [[x, -0.01, z] for x, z in ((0.1, 0.1), (0.18, 0.1), (0.18, 0.18), (0.1, 0.18))]
    sheet = np.array(corners), np.array([[0, 1, 2], [0, 2, 3]])
    parts = [box((0.0, 0.0, 0.0), (0.5, 0.3, 0.5)), sheet, disc((0.14, -0.035, 0.14), 0.025, 0.025)]
    (knob,) = find_controls(pieces_in(*parts), FRONT, [])
    assert knob.is_round
    assert len(knob.fragments) == 1


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
