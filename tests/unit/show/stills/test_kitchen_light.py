"""Light in pictures of kitchens: soft shadows, no dark corners, no void for an eye in the room that is lit."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.show.stills import kitchen
from casa_assets.show.stills.kitchen import PictureSettings, room_of
from casa_assets.show.stills.photoreal import View

FRAME = PictureSettings(160, 120, passes=4, shadow_px=256)
# A room of 4 x 4 x 2.5 m without a front wall; its left wall has a window. A box is on the floor, and a wall unit
# hangs on the back wall; both are red, so that they differ from walls and floor.
ROOM = """
<mujoco>
  <worldbody>
    <body name="floor" pos="2 -2 -0.05"><geom type="box" size="2 2 0.05" group="2" rgba="0.8 0.8 0.8 1"/></body>
    <body name="ceiling" pos="2 -2 2.55"><geom type="box" size="2 2 0.05" group="4" rgba="0.2 0.9 0.2 1"/></body>
    <body name="wall_back" pos="2 0.06 1.25"><geom type="box" size="2 0.06 1.25" group="2" rgba="0.8 0.8 0.8 1"/></body>
    <body name="wall_left" pos="-0.06 -2 1.25" euler="0 0 90">
      <geom type="box" size="2 0.06 1.25" group="2" rgba="0.8 0.8 0.8 1"/>
    </body>
    <body name="wall_right" pos="4.06 -2 1.25" euler="0 0 -90">
      <geom type="box" size="2 0.06 1.25" group="2" rgba="0.8 0.8 0.8 1"/>
    </body>
    <body name="unit" pos="2 -0.2 1.7"><geom type="box" size="0.5 0.2 0.35" group="2" rgba="0.8 0.1 0.1 1"/></body>
    <body name="box" pos="2 -2 0.25"><geom type="box" size="0.25 0.25 0.25" group="2" rgba="0.8 0.1 0.1 1"/></body>
    <camera name="ahead" pos="2 -3.9 1.4" xyaxes="1 0 0 0 0.1 1" fovy="60"/>
    <camera name="down" pos="2 -2 2.4" xyaxes="1 0 0 0 1 0" fovy="60"/>
    <camera name="out" pos="2 -1 1.3" xyaxes="-1 0 0 0 0 1" fovy="60"/>
    <camera name="overview" pos="2 -9 6" xyaxes="1 0 0 0 0.55 0.83" fovy="40"/>
    <camera name="wall" pos="2 -2 1.4" xyaxes="0 1 0 0 0 1" fovy="50"/>
  </worldbody>
</mujoco>
"""
Picture = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> kitchen.LoadedScene:
    scene = tmp_path_factory.mktemp("room") / "scene.xml"
    scene.write_text(ROOM.replace("</worldbody>", "</worldbody><keyframe><key name='start'/></keyframe>"))
    return kitchen.open_scene(scene, frame=FRAME)


@pytest.fixture(scope="module")
def pictures(made: kitchen.LoadedScene) -> dict[str, Picture]:
    """Picture of each camera, 0..255."""
    return {name: pixels.astype(np.float64) for name, pixels in kitchen.render_cameras(made, made.cameras, FRAME)}


def view_of(made: kitchen.LoadedScene, camera: str, fov_y_deg: float, shift_y: float = 0.0) -> View:
    """The view where a camera of the room is."""
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, made.data.camera(camera).xmat)
    half = math.tan(math.radians(fov_y_deg) / 2) * FRAME.width_px / FRAME.height_px
    x, y, z = (float(c) for c in made.data.camera(camera).xpos)
    w, i, j, k = (float(c) for c in turn)
    return View("eye", (x, y, z), (w, i, j, k), 2 * math.atan(half), shift_y)


def test_a_view_is_drawn_as_a_camera_there(pictures: dict[str, Picture], made: kitchen.LoadedScene) -> None:
    views = [view_of(made, "ahead", 60.0), view_of(made, "ahead", 60.0, shift_y=0.1)]
    (name, first), (_, second) = kitchen.render_cameras(made, views, FRAME)
    same, shifted = first.astype(np.float64), second.astype(np.float64)
    assert name == "eye"
    assert np.abs(same - pictures["ahead"]).mean() < 0.5
    # A lens that is shifted upwards shows more above: all that is seen moves down by that share of the width.
    rows = FRAME.width_px // 10
    assert np.abs(shifted[rows:] - same[:-rows]).mean() < 2.0 < np.abs(shifted - same).mean()


def test_the_floor_is_darker_below_things(pictures: dict[str, Picture]) -> None:
    floor = pictures["down"].mean(axis=2)
    red = pictures["down"][..., 0] - pictures["down"][..., 1] > 50
    rows, columns = np.flatnonzero(red.any(axis=1)), np.flatnonzero(red.any(axis=0))
    above = floor[rows[0] - 3, columns[4] : columns[-4]]
    assert above.mean() < 0.8 * np.percentile(floor[~red], 90)
    # Soft: the shadow fades, it has no edge.
    outwards = floor[: rows[0] - 2, columns[len(columns) // 2]]
    assert np.abs(np.diff(outwards)).max() < 0.2 * np.ptp(floor[~red])


def test_an_eye_in_the_room_sees_ceiling_and_a_plain_wall_where_there_is_none(pictures: dict[str, Picture]) -> None:
    green = {name: (p[..., 1] - p[..., 0] > 60).mean() for name, p in pictures.items()}
    assert green["ahead"] > 0.1
    assert green["overview"] == 0.0
    wall = pictures["out"][40:70, 40:120]
    assert 120 < wall.mean() < 235
    assert np.ptp(wall.mean(axis=(0, 1))) < 20
    # From outside, what lies beyond the room is paper.
    assert pictures["overview"][2, 2].min() > 240
    # Walls that the picture cuts are grey.
    overview = pictures["overview"].mean(axis=2)
    column = overview[:, 50]
    top = int(np.flatnonzero(column < 240)[0])
    assert column[top] < 0.8 * column[top + 8]


# A floor of two parts; a back wall with a pane of glass in it, and a front wall before the left half alone.
SHELL = """
<mujoco>
  <worldbody>
    <body name="floor" pos="0 0 -0.05">
      <geom type="box" size="1 2 0.05" pos="1 -2 0" group="2"/>
      <geom type="box" size="1 1 0.05" pos="3 -1 0" group="2"/>
    </body>
    <body name="ceiling" pos="2 -2 2.5">
      <geom type="box" size="2 2 0.05" pos="0 0 0.05" group="4"/>
      <geom type="box" size="0.1 2 0.1" pos="0 0 -0.1" group="4"/>
    </body>
    <body name="wall_back" pos="2 0.06 1.25"><geom type="box" size="2 0.06 1.25" group="2"/></body>
    <body name="wall_front" pos="1 -4.06 1.25" euler="0 0 180"><geom type="box" size="1 0.06 1.25" group="2"/></body>
    <body name="window" pos="2 0.06 1.5">
      <geom type="box" size="0.5 0.003 0.4" group="2" rgba="0.8 0.9 1 0.2"/>
    </body>
    <body name="fridge" pos="3 -0.3 1"><geom type="box" size="0.3 0.3 0.005" group="2" rgba="1 1 1 0.2"/></body>
  </worldbody>
</mujoco>
"""


def test_a_room_is_a_box_with_walls_in_parts_of_its_sides_and_windows_in_its_walls() -> None:
    model = mujoco.MjModel.from_xml_string(SHELL)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    room = room_of(model, data, (np.full(3, -9.0), np.full(3, 9.0)))
    assert room.lower == pytest.approx([0, -4, 0], abs=1e-6)
    assert room.upper == pytest.approx([4, 0, 2.5], abs=1e-6), "up to the ceiling over its beams"
    assert room.open_sides == [0, 1]
    places = np.array([(3, -4, 1), (1, -4, 1), (0, -1, 1), (1, -1, 0)], dtype=np.float32).T
    assert room.is_bare(places, np.array([2, 2, 0, 4])).tolist() == [True, False, True, False]
    (window,) = room.windows
    assert window.side == 3
    assert [*window.lower, *window.upper] == pytest.approx([1.5, 1.1, 2.5, 1.9])
