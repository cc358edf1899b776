"""A small kitchen with a worktop, a cupboard with a drawer and loose boxes, as a scene folder for start states."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from casa_assets.checks.start_states.draw import StateRequest, Wanted
from casa_assets.formats.mjcf import kitchen
from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.scene import Scene
from tests.support.asset.cupboard import cupboard
from tests.support.kitchen.rooms import at, block, room
from tests.support.kitchen.scenes import put

WORKTOP, CUPBOARD = "thing_0", "thing_1"
BOX_M = 0.06
LEVEL = (1.0, 0.0, 0.0, 0.0)
TOP_M = 0.9
PARKED = {"x": 0.0, "y": 0.2, "yaw": 1.5708, "side": "front"}
REGION = {"kind": "box", "link": "object", "quaternion": LEVEL}
FIXTURE = {"base": "fixed", "contract": None, "mass_kg": 1.0, "joints": {}, "regions": {}, "quaternion": LEVEL}


def wanted(count: int = 3, things: int = 2, opened: int = 0, seed: int = 0) -> Wanted:
    return Wanted("key", StateRequest(count, things, opened, seed), 0.001, 0.005)


def small_kitchen(boxes: int = 3, stacked: bool = False) -> Scene:
    """A worktop, a cupboard left of it, and boxes along the back of the worktop, or the second on the first."""
    loose = block("box", (BOX_M, BOX_M, BOX_M), Base.FREE)
    row = [(loose, at(-0.5 + 0.12 * k, 1.2, TOP_M)) for k in range(boxes)]
    if stacked:
        row[1] = (loose, at(-0.5, 1.2, TOP_M + BOX_M))
    return room((block("worktop", (1.6, 0.6, TOP_M)), at(0.0, 1.0, 0.0)), (cupboard(), at(-1.3, 1.2, 0.0)), *row)


def facts(boxes: int = 3, parked: Mapping[str, Any] = PARKED) -> dict[str, Any]:
    """As much of scene.json as start states are drawn from."""
    top = {**REGION, "size": [1.6, 0.6, 0.4], "position": [0.0, 1.0, TOP_M + 0.2]}
    drawer = {**REGION, "link": "drawer", "size": [0.48, 0.34, 0.12], "position": [-1.3, 1.179, 0.505]}
    slide = {"name": f"{CUPBOARD}__drawer_slide", "kind": "slide", "behind": None}
    loose = {**FIXTURE, "base": "free", "category": "cereal"}
    return {
        "id": "room",
        "base_radius": 0.3,
        "fixtures": [
            {**FIXTURE, "name": "ground", "category": "floor"},
            {**FIXTURE, "name": WORKTOP, "category": "counter", "regions": {"top": top}},
            {
                **FIXTURE,
                "name": CUPBOARD,
                "category": "drawer_stack",
                "regions": {"drawer_int": drawer},
                "joints": {"drawer_slide": slide},
            },
            *({**loose, "name": f"thing_{2 + k}"} for k in range(boxes)),
        ],
        "parking": {
            WORKTOP: {"shut": parked, "open": {}},
            CUPBOARD: {"shut": None, "open": {"drawer_slide": {**PARKED, "x": -1.3, "y": -0.2}}},
        },
    }


def scene_folder(root: Path, boxes: int = 3, parked: Mapping[str, Any] = PARKED, stacked: bool = False) -> Path:
    scene = small_kitchen(boxes, stacked)
    folder = put(kitchen.write(scene), root, scene)
    (folder / "scene.json").write_text(json.dumps(facts(boxes, parked)), encoding="utf-8")
    return folder


AGAINST_THE_WORKTOP = {**PARKED, "y": 0.9, "yaw": math.pi}
