"""Rooms that are not plain boxes: islands behind islands, tables, columns, niches, closets, slopes, walls aslant."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.scene.formats import SceneFiles, formats_agree
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.errors import RegistryError
from casa_assets.layouts.compose import pose_at_spot
from casa_assets.layouts.order.build_order import KitchenRequest, OrderItem
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.run.resolve import params_of, preset_params
from casa_assets.mesh.outline import contains_point
from casa_assets.model.kitchen.scene import Layer, Placement, Scene
from casa_assets.registry.kitchens import load_plan, load_style
from tests.support.asset.family_members import made
from tests.support.kitchen.plan_geometry import kitchen_of
from tests.support.kitchen.scenes import written

PLAN = """\
title: Studio
height: 2.7
walls:
  back: {heading: right, length: 5.6}
  right: {heading: front, length: 6.4}
  front: {heading: left, open: true}
  left: {heading: back}
runs:
  main:
    on: back
    base:
      - drawers: [0.4, 1.2]
      - sink
      - dishwasher
      - drawers: [0.4, 1.2]
      - range
      - fridge: {housing: false}
"""
ISLANDS = """\
  island:
    faces: {run: main, aisle: 1.2}
    overhang: 0.3
    base: [island]
  second:
    faces: {run: island, side: back, aisle: 1.1, shift: 0.2}
    base: [{drawers: 0.6}, {doors: 0.8}]
"""
CUT = "  cut: {heading: 45, length: 1.5}\n  right: {heading: front}\n"
ASLANT = PLAN.replace("  right: {heading: front, length: 6.4}\n", CUT).replace("length: 5.6", "length: 4.6")
ASLANT = ASLANT.replace("left: {heading: back}", "left: {heading: back, length: 6.4}")


def item(kitchen: KitchenRequest, name: str) -> OrderItem:
    return next(i for i in kitchen.items if i.name == name)


def place(kitchen: KitchenRequest, name: str) -> np.ndarray:
    """(8, 3) corners of the region `main` of an ordered item, in the room, metres."""
    found = item(kitchen, name)
    asset = made(found.choice.family, params_of(found.choice))
    region = next(r for r in asset.regions if r.name == "main")
    half = np.array(region.size) / 2
    ends = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    return np.asarray((pose_at_spot(asset, found.spot) @ asset.root.pose @ region.pose).apply(ends))


def test_a_second_island_stands_behind_the_first(tmp_path: Path) -> None:
    kitchen = kitchen_of(PLAN + ISLANDS, tmp_path)
    first, second = kitchen.lines["island"], kitchen.lines["second"]
    assert second.frame.turn_deg == first.frame.turn_deg
    assert second.is_island
    front = first.frame.to_local(*second.frame.at(0.0, second.depth + standard_sizes.WORKTOP_OVERHANG)[:2])[1]
    assert -front - first.depth_behind == pytest.approx(1.1)
    middle = first.frame.to_local(*second.frame.at(second.length / 2, 0.0)[:2])[0]
    assert middle == pytest.approx(first.length / 2 + 0.2)


TABLE = "tables:\n  dining: {wall: left, at: 2.0, from_wall: 2.0, chairs: 5, turn_deg: 30}\n"


@pytest.mark.parametrize("style", ["coastal", "modern_1"])
def test_chairs_stand_round_a_table_and_face_it(tmp_path: Path, style: str) -> None:
    kitchen = kitchen_of(PLAN + TABLE, tmp_path, style=style)
    table = kitchen.tables["dining"]
    chairs = [i for i in kitchen.items if i.role == "chair"]
    assert len(chairs) == 5
    for chair in chairs:
        x, y, _ = chair.spot.frame.at(chair.spot.u, chair.spot.v)
        turn = math.radians(chair.spot.frame.turn_deg + chair.spot.turn_deg)
        looks = (math.sin(turn), -math.cos(turn))  # the front of an asset looks to -y
        to_table = np.subtract(table.middle, (x, y))
        assert float(to_table @ looks) > 0.3
        assert contains_point(table.outline, (x, y))


def test_a_column_stands_at_a_wall_and_one_in_the_room(tmp_path: Path) -> None:
    columns = "columns:\n  pier: {wall: left, at: 2.0, width: 0.4, depth: 0.25}\n"
    columns += "  post: {wall: back, at: 3.0, from_wall: 3.0, shape: round, width: 0.2}\n"
    kitchen = kitchen_of(PLAN + columns, tmp_path)
    pier, post = place(kitchen, "pier"), place(kitchen, "post")
    assert (pier[:, 0].min(), pier[:, 0].max()) == pytest.approx((0.0, 0.265), abs=1e-6)
    assert pier[:, 1].mean() == pytest.approx(-4.4, abs=1e-6)
    assert post[:, 1].max() == pytest.approx(-3.0, abs=1e-6)
    assert pier[:, 2].max() == pytest.approx(2.7, abs=1e-6)
    assert len([i for i in kitchen.items if i.name.startswith("skirting_left")]) == 2


class TestNiches:
    NICHE = "openings:\n  cold: {kind: niche, wall: back, over: main_fridge, height: 2.0, depth: 0.4}\n"

    def test_a_refrigerator_stands_back_into_it(self, tmp_path: Path) -> None:
        text = PLAN.replace("on: back", "on: back\n    end: 0.2")
        kitchen, plain = kitchen_of(text + self.NICHE, tmp_path), kitchen_of(text, tmp_path)
        (hole,) = kitchen.holes
        slot = kitchen.slot("main_fridge")
        assert (hole.left, hole.right) == pytest.approx((slot.left, slot.right))
        moved = place(kitchen, "main_fridge")[:, 1].mean() - place(plain, "main_fridge")[:, 1].mean()
        assert moved == pytest.approx(0.4)
        shell = place(kitchen, "recess_cold")[:, 1]
        assert (shell.min(), shell.max()) == pytest.approx((0.0, 0.4 + 0.12), abs=1e-6)
        post = f"{{wall: back, at: {slot.middle:.3f}, from_wall: 0.5, width: 0.1, depth: 0.1}}"
        assert kitchen_of(f"{text}{self.NICHE}columns:\n  post: {post}\n", tmp_path).room.columns, "it stands before it"

    def test_a_seat_has_its_window_in_its_back(self, tmp_path: Path) -> None:
        seat = "  seat: {kind: niche, wall: left, at: 2.0, width: 1.5, height: 1.6, sill: 0.45, depth: 0.5}\n"
        pane = "  pane: {kind: window, wall: seat, at: 0.75, width: 1.1, height: 1.0, sill: 0.9}\n"
        kitchen = kitchen_of(f"{PLAN}openings:\n{seat}{pane}", tmp_path)
        window = place(kitchen, "pane")
        assert window[:, 0].max() < -0.4
        shell = item(kitchen, "recess_seat").choice.params
        assert shell["openings"] == [{"left": pytest.approx(0.2), "bottom": 0.45, "width": 1.1, "height": 1.0}]
        (hole,) = item(kitchen, "wall_left").choice.params["openings"]
        assert hole["bottom"] == pytest.approx(0.4)  # the slab of the seat lies in it

    def test_a_closet_lies_behind_its_door(self, tmp_path: Path) -> None:
        closet = "{width: 1.8, depth: 1.2, shelves: 3}"
        door = f"{{kind: door, wall: left, at: 3.0, width: 0.93, height: 2.04, closet: {closet}}}"
        kitchen = kitchen_of(f"{PLAN}openings:\n  pantry: {door}\n", tmp_path)
        shell, larders = place(kitchen, "recess_pantry"), [i for i in kitchen.items if i.role == "larder"]
        assert (shell[:, 0].min(), shell[:, 0].max()) == pytest.approx((-0.12 - 1.2 - 0.12, -0.12))
        assert len(larders) == 2
        for larder in larders:
            stands = place(kitchen, larder.name)
            assert stands[:, 0].max() < -0.12
            assert stands[:, 2].min() == pytest.approx(0.0, abs=1e-6)


SLOPE = "slopes:\n  - {wall: left, knee: 1.5, pitch_deg: 45}\n"
BACK_FROM = PLAN.replace("on: back", "on: back\n    start: 1.0")


def test_a_slope_leads_from_the_knee_to_the_level_part(tmp_path: Path) -> None:
    kitchen = kitchen_of(BACK_FROM + SLOPE, tmp_path)
    low = place(kitchen, "ceiling_slope_1")
    under = low[np.argsort(low[:, 2] + low[:, 0])]  # along the slope
    assert under[:, 2].min() == pytest.approx(1.5, abs=1e-5)
    level = place(kitchen, "ceiling")
    assert level[:, 0].min() == pytest.approx(1.2, abs=1e-5)
    assert item(kitchen, "wall_left").choice.params["height"] == 1.5
    assert kitchen.room.ceiling_at(0.4, -2.0) == pytest.approx(1.9)
    assert kitchen.room.ceiling_at(3.0, -2.0) == 2.7
    edge = low[np.isclose(low[:, 0], 1.2, atol=1e-5)]
    assert edge[:, 2].min() == pytest.approx(2.7, abs=1e-5)


def test_walls_aslant_close_and_a_run_stands_at_one(tmp_path: Path) -> None:
    room = kitchen_of(ASLANT, tmp_path).room
    share = 1.5 * math.sqrt(0.5)
    lengths = {w.id: w.length for w in room.walls}
    assert lengths["right"] == pytest.approx(6.4 - share, abs=1e-4)
    assert lengths["front"] == pytest.approx(4.6 + share, abs=1e-4)
    assert not room.contains(4.6 + share - 0.1, -0.1)
    assert room.contains(4.6, -0.5)
    text = ASLANT.replace("runs:\n", "runs:\n  bar:\n    on: cut\n    start: 0.4\n    base: [{drawers: 0.6}]\n")
    kitchen = kitchen_of(text.replace("length: 4.6", "length: 5.2"), tmp_path)
    corners = place(kitchen, "bar_drawers")
    assert kitchen.lines["bar"].frame.more_deg == 45.0
    frame = next(w.frame for w in kitchen.room.walls if w.id == "cut")
    before = [frame.to_local(x, y)[1] for x, y, _ in corners]
    assert (min(before), max(before)) == pytest.approx((0.0, standard_sizes.BASE_DEPTH), abs=1e-4)


BAR = ASLANT.replace("runs:\n", "runs:\n  bar:\n    on: cut\n    base: [{drawers: 0.6}]\n")
TOO_HIGH = "{kind: niche, wall: left, at: 2.0, height: 2.4, sill: 0.5, depth: 0.3}"
# What is written behind the plan, and what is said of it.
REFUSED = [
    ("  i:\n    faces: {run: main, side: back}\n    base: [island]\n", "tiny.yaml:.*side.*front, since that run"),
    ("columns:\n  post: {wall: back, at: 2.0}\n", "a place apart from main_"),
    ("columns:\n  post: {wall: back, at: 9.0, from_wall: 3.0}\n", "a place inside the room"),
    ("openings:\n  o: {kind: niche, wall: left, at: 2.0}\n", "a niche needs a `depth`"),
    (f"openings:\n  o: {TOO_HIGH}\n", "a hole inside 6.40 x 2.70 m"),
    ("slopes:\n  - {wall: back, knee: 1.5, pitch_deg: 40}\n", r"a ceiling of at least \d.\d+ m over main_"),
    ("slopes:\n  - {wall: left, knee: 1.0, pitch_deg: 15}\n", "a slope that reaches at most 5.20 m into the room"),
    (SLOPE + "  - {wall: front, knee: 1.5, pitch_deg: 45}\n", "beside which no other slope begins"),
]
REFUSED_ASLANT = [
    (ASLANT.replace("heading: 45", "heading: 135"), "at a right angle to the next, or one that turns"),
    (ASLANT.replace("heading: 45, length: 1.5", "heading: 45"), "a length, since it stands aslant"),
    (BAR + "corners:\n  - {runs: [main, bar], base: dead}\n", "runs that meet at a right angle"),
]


def test_what_cannot_be_built_is_refused(tmp_path: Path) -> None:
    for text, said in [*((PLAN + more, said) for more, said in REFUSED), *REFUSED_ASLANT]:
        text = text.replace("on: back", "on: back\n    start: 1.0") if "wall: front, knee" in text else text
        with pytest.raises(RegistryError, match=said):
            kitchen_of(text, tmp_path)


@pytest.mark.parametrize("name", ["attic", "l_bay", "l_columns", "pantry_island"])
def test_both_formats_say_the_same_of_the_room(name: str, tmp_path: Path) -> None:
    """Shell, slopes, columns and recesses of a plan, without its units."""
    kitchen = request_kitchen(load_plan(name)[0], load_style("coastal")[0], preset_params(), closed=True)
    shell = [i for i in kitchen.items if i.layer != "things" and i.choice.family not in ("window", "door")]
    built = {i.name: made(i.choice.family, params_of(i.choice)) for i in shell}
    poses = {i.name: pose_at_spot(built[i.name], i.spot) for i in shell}
    places = [Placement(name=i.name, asset=built[i.name].id, pose=poses[i.name], layer=Layer(i.layer)) for i in shell]
    assets = {a.id: a for a in built.values()}
    scene = Scene(id=f"{name}__shell", assets=tuple(assets.values()), placements=tuple(places))
    files = SceneFiles(SceneSubject(scene, written(scene, tmp_path)))
    assert formats_agree(files, 0.0).problems == ()
    assert mujoco_facts.facts_of_scene(files.scene_subject.loaded.model)["placements"].keys() == built.keys()
