"""Two small kitchens as batch forms are written, of different plans, to be put into one structure, and a robot."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco

# Where a robot parks in both.
PARKED = {"x": 1.0, "y": -1.2, "yaw": 1.5707963}
_HERE = Path(__file__).parent
FIRST, SECOND = ((_HERE / f"{name}.xml").read_text() for name in ("first", "second"))
_ROBOT = """<mujoco model="bot"><worldbody><body name="base" pos="0 0 0.12">
  {joint}
  <geom type="box" size="0.2 0.2 0.1" mass="20"/>
  <body name="arm" pos="0 0 0.3">
    <joint name="lift" type="hinge" axis="0 1 0" damping="2"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="1"/>
  </body></body></worldbody>
  <actuator><position name="lift" joint="lift" kp="60"/></actuator>
  <keyframe><key name="home" qpos="{home}" ctrl="-0.4"/></keyframe></mujoco>"""
DRIVING = _ROBOT.format(joint='<joint name="x" type="slide" axis="1 0 0" damping="50"/>', home="0.1 -0.4")
FLOATING = _ROBOT.format(joint="<freejoint/>", home="5 5 0.11 1 0 0 0 -0.4")


def specs() -> list[mujoco.MjSpec]:
    """Both kitchens."""
    return [mujoco.MjSpec.from_string(text) for text in (FIRST, SECOND)]


def folders(out: Path) -> list[Path]:
    """Folders of scenes with the batch forms of both."""
    found = []
    for name, text in (("first", FIRST), ("second", SECOND)):
        (out / name).mkdir(parents=True)
        (out / name / "scene_batch.xml").write_text(text)
        (out / name / "scene.json").write_text(json.dumps({"parking": {"top": {"shut": PARKED}}}))
        found.append(out / name)
    return found
