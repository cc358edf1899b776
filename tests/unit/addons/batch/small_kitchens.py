"""Two small kitchens as batch forms are written, of different plans, to be put into one structure, and a robot."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import mujoco
from lxml import etree

from casa_assets.model.kitchen.scene import StartStates
from tests.support.kitchen.scenes import start_states

# Where a robot parks in both.
PARKED = {"x": 1.0, "y": -1.2, "yaw": 1.5707963}
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
# What has a picture in each: the name of the picture and MuJoCo's builtin that makes it. `tiles` is in both.
_OAK = ("oak", 'builtin="checker" rgb1="1 0.5 0.2" rgb2="0.5 0.2 0"')
_TILES = ("tiles", 'builtin="flat" rgb1="0.2 0.4 0.6"')
JOINTS = [
    {"name": name, "address": address, "width": width}
    for name, address, width in (("base__hinge", 0, 1), ("locked__slide", 1, 1), ("plate__free", 2, 7))
]
REST = [0.0, 0.0, 0.7, -0.3, 0.92, 1.0, 0.0, 0.0, 0.0]


_HERE = Path(__file__).parent
FIRST, SECOND = ((_HERE / f"{name}.xml").read_text() for name in ("first", "second"))
_PAINTED = ((FIRST, {"floor__floor": _TILES, "top__slab": _OAK}), (SECOND, {"floor__floor": _TILES}))


def painted() -> list[str]:
    return [_with_pictures(text, shown) for text, shown in _PAINTED]


def _with_pictures(text: str, shown: Mapping[str, tuple[str, str]]) -> str:
    root = etree.fromstring(text)
    block = root.find("asset")
    assert block is not None
    for geom, (name, look) in shown.items():
        how = 'texuniform="true" texrepeat="4 2" shininess="0.3"'
        block.append(etree.fromstring(f'<texture name="{name}" type="2d" {look} width="8" height="8"/>'))
        block.append(etree.fromstring(f'<material name="{name}_m" texture="{name}" {how}/>'))
        (found,) = root.iterfind(f".//geom[@name='{geom}']")
        del found.attrib["rgba"]
        found.set("material", f"{name}_m")
    block.append(etree.fromstring(f'<material name="plain_{root.get("model")}" rgba="0.1 0.2 0.3 1"/>'))
    return etree.tostring(root, encoding="unicode")


def specs() -> list[mujoco.MjSpec]:
    return [mujoco.MjSpec.from_string(text) for text in (FIRST, SECOND)]


def folders(out: Path, has_pictures: bool = False) -> list[Path]:
    found = []
    for name, text in zip(("first", "second"), painted() if has_pictures else (FIRST, SECOND), strict=True):
        (out / name).mkdir(parents=True)
        (out / name / "scene_batch.xml").write_text(text)
        (out / name / "scene.json").write_text(json.dumps({"parking": {"top": {"shut": PARKED}}}))
        found.append(out / name)
    return found


def states(*rows: tuple[list[float], tuple[str, ...]]) -> StartStates:
    notes = [{"placed": {}, "parked": "base", "opened": opened} for _, opened in rows]
    base = [[number, 2.0, 0.5] for number in range(len(rows))]
    return start_states("l_small__coastal", JOINTS, [row for row, _ in rows], base=base, notes=notes)
