"""The room that a compiled kitchen is: its box, where walls are missing, its windows, and how bright it is seen."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.show.stills.kitchen import room_of
from casa_assets.show.stills.room_light import CEILING, FLOOR, Room

# A floor of two parts; a back wall with a pane of glass in it, and a front wall before the left half alone.
ROOM = """
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


@pytest.fixture(scope="module")
def room() -> Room:
    model = mujoco.MjModel.from_xml_string(ROOM)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return room_of(model, data, (np.full(3, -9.0), np.full(3, 9.0)))


def column(*values: float) -> np.ndarray:
    return np.array(values, dtype=np.float32)[:, None]


def test_the_box_goes_round_all_parts_of_the_floor_up_to_the_ceiling_over_its_beams(room: Room) -> None:
    assert room.lower == pytest.approx([0, -4, 0], abs=1e-6)
    assert room.upper == pytest.approx([4, 0, 2.5], abs=1e-6)


def test_a_side_may_have_a_wall_in_a_part_of_it(room: Room) -> None:
    assert room.open_sides == [0, 1]
    front, left, floor = np.array([2]), np.array([0]), np.array([4])
    assert room.is_bare(column(3, -4, 1), front).all()
    assert not room.is_bare(column(1, -4, 1), front).any()
    assert room.is_bare(column(0, -1, 1), left).all()
    assert not room.is_bare(column(1, -1, 0), floor).any()


def test_glass_in_a_wall_is_a_window_and_glass_in_a_fridge_is_none(room: Room) -> None:
    (window,) = room.windows
    assert window.side == 3
    assert [*window.lower, *window.upper] == pytest.approx([1.5, 1.1, 2.5, 1.9])


def test_a_ray_sees_the_side_that_it_leaves_through(room: Room) -> None:
    at = column(2, -2, 1.2)
    assert room.seen(at, column(0, 0, 1))[0] == pytest.approx(CEILING, abs=1e-5)
    assert room.seen(at, column(0, 0, -1))[0] == pytest.approx(FLOOR, abs=1e-5)
    ways, sides = room.ways(at, column(0, 1, 0))
    assert ways.min() == pytest.approx(2.0, abs=1e-5)
    assert sides[ways.argmin()] == 3
    through_window, beside = room.seen(at, column(0, 1, 0.15)), room.seen(at, column(0.8, 1, 0.0))
    assert (through_window > 2.0 * beside).all()
