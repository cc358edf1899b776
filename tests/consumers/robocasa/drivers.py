"""Moves each atomic task of RoboCasa v1.0 to its goal: sets joints, moves objects, presses keys with the hand.

`DRIVERS[task](env)` is a generator. Each step of it leaves the simulation in a state that may be the goal; the caller
lets things come to rest, asks the task's own `_check_success`, and goes back to where it was before the next one.
Runs in RoboCasa's own environment.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from robocasa.models.fixtures import Counter
from robocasa.utils.env_utils import detect_robot_collision, set_robot_to_position

Attempts = Iterator[None]
AWAY = (10.0, 10.0, 0.0)  # outside the room, where RoboCasa itself keeps the robot while it makes the scene
RISES_M = (0.0, 0.02, 0.04)
GRID = (0.5, 0.3, 0.7, 0.15, 0.85)  # shares of a region's width and depth at which an object is tried
DROP_M = 0.004
# As it usually lies, and a quarter turn about x and about y, (w, x, y, z).
HALF = float(np.sqrt(0.5))
LYING, STOOD_X, STOOD_Y = (1.0, 0.0, 0.0, 0.0), (HALF, HALF, 0.0, 0.0), (HALF, 0.0, HALF, 0.0)
FINGER = "gripper0_right_finger1_pad_collision"
BASE = ("mobilebase0_joint_mobile_forward", "mobilebase0_joint_mobile_side", "mobilebase0_joint_torso_height")


def retreat(env: Any) -> None:
    set_robot_to_position(env, np.array(AWAY))


def press(env: Any, geom: str) -> None:
    """Bring a finger to a key, tell the fixtures, and take the robot out of the room."""
    data, model = env.sim.data, env.sim.model
    way = np.array(data.get_geom_xpos(geom)) - np.array(data.get_geom_xpos(FINGER))
    axes = np.array([data.xaxis[model.joint_name2id(name)] for name in BASE]).T
    for name, moved in zip(BASE, np.linalg.solve(axes, way), strict=True):
        data.qpos[model.get_joint_qpos_addr(name)] += moved
    env.sim.forward()
    env.update_state()
    retreat(env)
    env.update_state()


def once(act: Callable[[Any], object]) -> Callable[[Any], Attempts]:
    """One attempt, with the robot out of the room."""

    def attempt(env: Any) -> Attempts:
        retreat(env)
        act(env)
        yield

    return attempt


def turn(env: Any, fixture: Any, joint: str, value: float) -> None:
    """A joint of a fixture, by the name in its file, to a value in rad or m."""
    env.sim.data.set_joint_qpos(f"{fixture.naming_prefix}{joint}", value)


def move(env: Any, fixture: Any, joints: Any, share: float) -> None:
    """Joints of a fixture to a share of their range, as RoboCasa counts it."""
    assert joints, f"{fixture.name} has no such joint"
    fixture.set_joint_state(env=env, min=share, max=share, joint_names=list(joints))


def slide(env: Any, fixture: Any) -> None:
    level = {"rack_level": env.rack_level} if hasattr(env, "rack_level") else {}
    fixture.slide_rack(env, value=1.0 if env.should_pull else 0.0, **level)


def warm(env: Any) -> None:
    low, high = (0.70, 0.80) if env.target_temp_state == "hot" else (0.20, 0.30)
    env.sink.set_temp_state(env, env.rng, min_temp=low, max_temp=high)


def pressed(env: Any, fixture: Any, key: str) -> Attempts:
    press(env, f"{fixture.naming_prefix}{key}")
    yield


def arrived(env: Any) -> Attempts:
    """The robot within 0.16 m of the place of its goal, touching nothing."""
    ahead = np.array([np.cos(env.target_ori[2]), np.sin(env.target_ori[2])])
    aside = np.array([-ahead[1], ahead[0]])
    steps = [(u, v) for u in np.linspace(-0.16, 0.16, 9) for v in np.linspace(-0.16, 0.16, 9) if np.hypot(u, v) < 0.17]
    yaw = env.target_ori[2] - env.init_robot_base_ori_anchor[2]
    for turn in (0.0, 0.15, -0.15):
        for u, v in sorted(steps, key=lambda step: float(np.hypot(*step))):
            angle = (yaw + turn + np.pi) % (2 * np.pi) - np.pi
            env.sim.data.set_joint_qpos("mobilebase0_joint_mobile_yaw", angle)
            place = np.array([*(np.array(env.target_pos[:2]) + u * ahead + v * aside), env.target_pos[2]])
            set_robot_to_position(env, place)
            # The base turns about a point beside its middle, which RoboCasa's function takes for one.
            missed = place - env.sim.data.get_body_xpos("mobilebase0_base")
            set_robot_to_position(env, place + missed * (1.0, 1.0, 0.0))
            env.sim.forward()
            if not detect_robot_collision(env):
                yield


def put(env: Any, thing: Any, foot: Any, quaternion: Any = LYING) -> list[str]:
    """Stand an object on a point of the world, turned by a quaternion (w, x, y, z).

    Returns:
        Names of the geoms that it touches or lies in.
    """
    joint = thing.joints[0]
    w, x, y, z = quaternion
    lowest = min(float(corner[2]) for corner in thing.get_bbox_points(trans=np.zeros(3), rot=np.array([x, y, z, w])))
    place = np.array(foot) + np.array([0.0, 0.0, DROP_M - lowest])
    env.sim.data.set_joint_qpos(joint, np.concatenate([place, quaternion]))
    env.sim.data.set_joint_qvel(joint, np.zeros(6))
    env.sim.forward()
    own = set(thing.contact_geoms)
    touching = [c for c in env.sim.data.contact[: env.sim.data.ncon] if c.dist <= 0.0]
    pairs = [[env.sim.model.geom_id2name(g) for g in (c.geom1, c.geom2)] for c in touching]
    return [other for names in pairs for name, other in (names, names[::-1]) if name in own]


def in_boxes(env: Any, thing: Any, boxes: Any) -> Attempts:
    """An object on the floor of boxes, each (p0, px, py, pz) in the world, where it touches nothing else.

    Where it does not fit as it usually lies it is stood up, such as a banana in the jar of a blender, and then let fall
    from higher up, such as an apple into a jar that is narrow at its foot.
    """
    retreat(env)
    for rise, quaternion, (p0, px, py, _) in itertools.product(RISES_M, (LYING, STOOD_X, STOOD_Y), boxes):
        for v, u in itertools.product(GRID, GRID):
            if not put(env, thing, p0 + u * (px - p0) + v * (py - p0) + (0.0, 0.0, rise), quaternion):
                yield


def inside(env: Any, name: str, fixture: Any, *regions: str) -> Attempts:
    """An object in a fixture, where RoboCasa has its regions; in those whose names are given."""
    found = fixture.get_int_sites(relative=False)
    assert found, f"{fixture.name} has no region"
    return in_boxes(env, env.objects[name], [found[key] for key in regions or found])


def on_counter(env: Any, thing: Any, counters: Any) -> Attempts:
    from robocasa.utils.object_utils import get_pos_after_rel_offset

    boxes = []
    for counter in counters:
        for region in counter.get_reset_regions(env).values():
            half = np.array([*region["size"], 0.0]) / 2
            corners = [np.array(region["offset"]) + half * sign for sign in ((-1, -1, 0), (1, -1, 0), (-1, 1, 0))]
            p0, px, py = (get_pos_after_rel_offset(counter, corner) for corner in corners)
            boxes.append((p0, px, py, None))
    return in_boxes(env, thing, boxes)


def over(env: Any, name: str, below: str) -> Attempts:
    """An object let fall onto or into another, from just above what it meets there."""
    retreat(env)
    start = np.array(env.sim.data.body_xpos[env.obj_body_id[below]])
    top = start[2] + env.objects[below].top_offset[2]
    wide, deep = np.array(env.objects[below].size[:2]) / 2
    turn = np.array(env.sim.data.body_xmat[env.obj_body_id[below]]).reshape(3, 3)
    for u, v in ((0, 0), (0.3, 0), (0, 0.3), (-0.3, 0), (0, -0.3), (0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5)):
        aside = turn @ (u * wide, v * deep, 0.0)
        for z in np.arange(start[2] + env.objects[below].bottom_offset[2], top + 0.05, 0.005):
            if not put(env, env.objects[name], (start[0] + aside[0], start[1] + aside[1], z)):
                yield
                break


def at_site(env: Any, name: str, fixture: Any, site: str) -> Attempts:
    retreat(env)
    x, y, z = env.sim.data.get_site_xpos(f"{fixture.naming_prefix}{site}")
    for up in np.arange(-0.02, 0.04, 0.004):
        if not put(env, env.objects[name], (x, y, z + up)):
            yield


def in_fridge(env: Any, kind: str, **where: int) -> Attempts:
    regions = env.fridge.get_reset_regions(env, compartment="fridge", reg_type=(kind), **where)
    return inside(env, "obj", env.fridge, *regions)


def racks(env: Any, name: str, fixture: Any) -> Attempts:
    retreat(env)
    (key,) = fixture.get_reset_regions(env, rack_level=env.rack_level)
    center = np.array(env.sim.data.get_geom_xpos(f"{fixture.naming_prefix}reg_{key}"))
    p0, px, py, pz = fixture.get_int_sites(relative=False)[key]
    shift = center - (px + py + pz - p0) / 2
    return in_boxes(env, env.objects[name], [(p0 + shift, px + shift, py + shift, None)])


def lid_on(env: Any) -> Attempts:
    retreat(env)
    for up in np.arange(0.0, 0.03, 0.002):
        x, y, z = env.blender.get_lid_closed_pos(env)
        env.sim.data.set_joint_qpos(env.blender.blender_lid.joints[0], np.array([x, y, z + up, 1.0, 0.0, 0.0, 0.0]))
        yield


def _doors(name: str, share: float) -> Callable[[Any], Attempts]:
    """Joints that RoboCasa asks whether a fixture is open; of a refrigerator those of its upper compartment."""

    def act(env: Any) -> None:
        fixture = getattr(env, name)
        move(env, fixture, getattr(fixture, "_fridge_door_joint_names", None) or fixture.door_joint_names, share)

    return once(act)


def _joint(name: str, joint: str, share: float) -> Callable[[Any], Attempts]:
    return once(lambda env: move(env, getattr(env, name), [getattr(env, name)._joint_names[joint]], share))


def _counters(env: Any) -> list[Any]:
    return [f for f in env.fixtures.values() if isinstance(f, Counter)]


FIXTURES = ("Cabinet", "Microwave", "Fridge", "Oven", "Dishwasher")
# Ways of an object that ends in or on a container.
WAYS = "SinkToCounter CounterToMicrowave MicrowaveToCounter CounterToStove StoveToCounter ToasterOvenToCounter"
DRIVERS: dict[str, Callable[[Any], Attempts]] = {
    **{f"Open{name}": _doors("fxtr", 0.95) for name in FIXTURES},
    **{f"Close{name}": _doors("fxtr", 0.0) for name in FIXTURES},
    "OpenToasterOvenDoor": _doors("toaster_oven", 0.95),
    "CloseToasterOvenDoor": _doors("toaster_oven", 0.0),
    "OpenDrawer": once(lambda env: move(env, env.drawer, env.drawer.door_joint_names, 1.0)),
    "CloseDrawer": once(lambda env: move(env, env.drawer, env.drawer.door_joint_names, 0.0)),
    "SlideDishwasherRack": once(lambda env: slide(env, env.dishwasher)),
    "SlideOvenRack": once(lambda env: slide(env, env.oven)),
    "SlideToasterOvenRack": once(lambda env: slide(env, env.toaster_oven)),
    "OpenFridgeDrawer": once(lambda env: move(env, env.fridge, env.fridge._get_drawer_joints("fridge", -1), 0.9)),
    "CloseFridgeDrawer": once(lambda env: move(env, env.fridge, env.fridge._get_drawer_joints("fridge", -1), 0.0)),
    "PreheatOven": _joint("oven", "temperature", 0.6),
    "AdjustToasterOvenTemperature": once(
        lambda env: env.toaster_oven.set_temperature(env, env.initial_temp + (0.3 if env.should_increase else -0.3))
    ),
    "TurnOnToasterOven": _joint("toaster_oven", "time", 0.6),
    "TurnOnElectricKettle": _joint("electric_kettle", "switch", 1.0),
    "CloseElectricKettleLid": _joint("electric_kettle", "lid", 0.0),
    "OpenElectricKettleLid": _joint("electric_kettle", "lid", 1.0),
    "OpenStandMixerHead": _joint("stand_mixer", "head", 1.0),
    "CloseStandMixerHead": _joint("stand_mixer", "head", 0.0),
    "TurnOnStove": once(lambda env: turn(env, env.stove, f"knob_{env.knob}_joint", 1.2)),
    "TurnOffStove": once(lambda env: turn(env, env.stove, f"knob_{env.knob}_joint", 0.0)),
    "LowerHeat": once(lambda env: turn(env, env.stove, f"knob_{env.knob}_joint", 0.8)),
    "TurnOnSinkFaucet": once(lambda env: turn(env, env.sink, "handle_joint", 0.48)),
    "TurnOffSinkFaucet": once(lambda env: turn(env, env.sink, "handle_joint", 0.0)),
    "TurnSinkSpout": once(lambda env: turn(env, env.sink, "spout_joint", 0.65 if env.behavior == "right" else -0.65)),
    "AdjustWaterTemperature": once(warm),
    "TurnOnToaster": once(lambda env: [env.toaster.set_lever(env, pair, 1.0) for pair in env.toaster.get_state(env)]),
    "StartCoffeeMachine": lambda env: pressed(env, env.coffee_machine, env.coffee_machine._start_button_names[0]),
    "TurnOnMicrowave": lambda env: pressed(env, env.microwave, "start_button"),
    "TurnOffMicrowave": lambda env: pressed(env, env.microwave, "stop_button"),
    "TurnOnBlender": lambda env: pressed(env, env.blender, "power_button_main"),
    "OpenBlenderLid": lambda env: on_counter(env, env.blender.blender_lid, _counters(env)),
    "CloseBlenderLid": lid_on,
    "NavigateKitchen": arrived,
    "CoffeeSetupMug": lambda env: at_site(env, "obj", env.coffee_machine, "receptacle_place_site"),
    "CoffeeServeMug": lambda env: on_counter(env, env.objects["obj"], [env.counter]),
    "PickPlaceCounterToCabinet": lambda env: inside(env, "obj", env.cab),
    "PickPlaceCabinetToCounter": lambda env: on_counter(env, env.objects["obj"], [env.counter]),
    "PickPlaceCounterToSink": lambda env: inside(env, "obj", env.sink),
    "PickPlaceCounterToDrawer": lambda env: inside(env, "obj", env.drawer),
    "PickPlaceDrawerToCounter": lambda env: on_counter(env, env.objects["obj"], _counters(env)),
    "PickPlaceCounterToBlender": lambda env: inside(env, "obj", env.blender),
    "PickPlaceCounterToStandMixer": lambda env: inside(env, "obj", env.stand_mixer),
    "PickPlaceCounterToToasterOven": lambda env: racks(env, "obj", env.toaster_oven),
    "PickPlaceFridgeShelfToDrawer": lambda env: in_fridge(env, "drawer", rack_index=-1),
    "PickPlaceFridgeDrawerToShelf": lambda env: in_fridge(env, "shelf"),
    "PickPlaceCounterToOven": lambda env: over(env, "obj", "oven_tray"),
    "PickPlaceToasterToCounter": lambda env: over(env, "obj", "plate"),
    **{f"PickPlace{way}": lambda env: over(env, "obj", "container") for way in WAYS.split()},
    "CheesyBread": lambda env: over(env, "cheese", "bread"),
    "MakeIcedCoffee": lambda env: over(env, "ice_cube1", "cup"),
    "PackDessert": lambda env: over(env, "dessert", "cooked_food_container"),
}
