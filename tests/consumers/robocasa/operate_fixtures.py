"""Operates fixtures of ours with RoboCasa's own classes and puts cubes where they put things. Prints one JSON object.

    python operate_fixtures.py TASK.json

Runs in RoboCasa's environment. TASK.json has `fixtures` (objects with `name`, `class`, `folder` and, for a blender,
`lid`; folders lie beside it, each with a model.xml) and `classes`, of which it says whether they take a file.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
from robosuite.models.world import MujocoWorldBase
from robosuite.utils.binding_utils import MjSim

# Height that a fixture of a class stands at, metres; those that are let into a worktop have their top there.
WORKTOP = 0.92
HEIGHTS = {"Oven": 0.4, "Microwave": 1.3, "Hood": 1.6}
LET_IN = ("Sink", "Stovetop")
ON_THE_FLOOR = ("Stove", "Dishwasher")
CUBE_M, MOST_CUBES, LIFT_M = 0.05, 8, 0.002
SETTLE_S = 1.5
# A cube stays where it was put: this far it may slide or sink, metres.
STAYS_M = 0.02
SAME_PLACE_M = 1e-4
PROBE = "probe_geom"


class Bench:
    def __init__(self, fixture: Any, *others: Any) -> None:
        world = MujocoWorldBase()
        for each in (fixture, *others):
            world.merge_assets(each)
            world.worldbody.append(each.get_obj())
        spec = mujoco.MjSpec.from_string(world.get_xml())
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[9.0, 9.0, 1.0])
        for k in range(MOST_CUBES):
            cube = spec.worldbody.add_body(name=f"cube{k}", pos=_parked(k))
            cube.add_freejoint(name=f"cube{k}_joint")
            cube.add_geom(name=f"cube{k}_geom", size=[CUBE_M / 2] * 3, mass=0.1, type=mujoco.mjtGeom.mjGEOM_BOX)
        probe = spec.worldbody.add_body(name="probe", mocap=True, pos=[0.0, -5.0, 0.1])
        probe.add_geom(name=PROBE, size=[0.003] * 3, contype=2, conaffinity=3)
        self.sim = MjSim(spec.compile())
        self.sim.forward()
        self.fixture = fixture
        self.rng = np.random.default_rng(0)
        self.robots = [SimpleNamespace(gripper={"right": PROBE})]
        self.wrong: list[str] = []

    def ask(self, holds: Any, told: str) -> None:
        """Keeps what is to be told where something does not hold."""
        if not holds:
            self.wrong.append(told)

    @property
    def model(self) -> mujoco.MjModel:
        return self.sim.model._model

    @property
    def data(self) -> mujoco.MjData:
        return self.sim.data._data

    def check_contact(self, one: Any, other: str) -> bool:
        wanted = {self.model.geom(one).id, self.model.geom(other).id}
        return any(set(pair) == wanted for pair in self.data.contact.geom)

    def touch(self, name: str | None) -> None:
        """Puts the fingertip into a geom, or away from everything, and lets the class look."""
        at = [0.0, -5.0, 0.1] if name is None else self.data.geom(name).xpos
        self.data.mocap_pos[0] = at
        self.sim.forward()
        self.fixture.update_state(self)

    def resize(self, k: int, edge: float) -> None:
        self.model.geom(f"cube{k}_geom").size[:] = edge / 2

    def put(self, k: int, at: np.ndarray) -> None:
        self.data.joint(f"cube{k}_joint").qpos[:] = [*at, 1.0, 0.0, 0.0, 0.0]
        self.data.joint(f"cube{k}_joint").qvel[:] = 0.0

    def settle(self, held: dict[str, float]) -> None:
        """Lets time pass; the joints in `held` keep their places, as a hand would hold them."""
        for _ in range(int(SETTLE_S / self.model.opt.timestep)):
            for name, value in held.items():
                self.data.joint(name).qpos[0], self.data.joint(name).qvel[0] = value, 0.0
            mujoco.mj_step(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)

    def joints(self) -> dict[str, float]:
        return {name: float(self.data.joint(name).qpos[0]) for name in self.fixture._joint_infos}


def _parked(k: int) -> list[float]:
    return [3.0 + 0.3 * k, 0.0, 0.03]


def operate(bench: Bench, kind: str) -> None:
    fixture = bench.fixture
    if kind.startswith("Fridge"):
        _fridge(bench)
    elif kind in ("Stove", "Stovetop"):
        _stove(bench)
    elif fixture.door_joint_names and (kind == "Microwave" or fixture._joint_infos):
        _door(bench)
    others = {
        "Oven": _oven, "ToasterOven": _toaster_oven, "Dishwasher": _dishwasher, "Microwave": _microwave,
        "Toaster": _toaster, "Blender": _blender, "CoffeeMachine": _coffee, "ElectricKettle": _kettle,
        "StandMixer": _mixer, "Sink": _sink,
    }  # fmt: skip
    if kind in others:
        others[kind](bench)


def _door(bench: Bench, of: str = "", **part: Any) -> None:
    """`of`: words for a part of the fixture; `part`: the same for the class."""
    bench.fixture.open_door(bench, **part)
    bench.ask(bench.fixture.is_open(bench, **part), f"open_door{of}, then is_open is False")
    bench.fixture.close_door(bench, **part)
    bench.ask(bench.fixture.is_closed(bench, **part), f"close_door{of}, then is_closed is False")


def _fridge(bench: Bench) -> None:
    fixture = bench.fixture
    for part in ("fridge", "freezer"):
        _door(bench, f" of the {part}", compartment=part)
        doors = fixture._fridge_door_joint_names if part == "fridge" else fixture._freezer_door_joint_names
        bench.ask(doors, f"no door of the {part}")
        if not fixture._get_drawer_joints(part):
            continue
        fixture.open_door(bench, compartment=part, reg_type="drawer")
        is_open = fixture.is_open(bench, compartment=part, reg_type="drawer")
        bench.ask(is_open, f"open_door of the {part}'s drawers, then is_open is False")
        fixture.close_door(bench, compartment=part, reg_type="drawer")
    _pulled_drawers(bench)


def _pulled_drawers(bench: Bench) -> None:
    """Doors at 0.90, where is_open begins, and drawers all the way out: they do not run into each other."""
    fixture, prefix = bench.fixture, bench.fixture.naming_prefix
    for part in ("fridge", "freezer"):
        if not fixture._get_drawer_joints(part):
            continue
        fixture.open_door(bench, min=0.9, max=0.9, compartment=part)
        fixture.open_door(bench, min=1.0, max=1.0, compartment=part, reg_type="drawer")
        bench.sim.forward()
        own = [c for c in bench.data.contact if all(bench.model.geom(g).name.startswith(prefix) for g in c.geom)]
        deepest = max((-float(contact.dist) for contact in own), default=0.0)
        bench.ask(deepest <= 0.001, f"doors of the {part} at 0.90 stand {1000 * deepest:.0f} mm in its pulled drawers")
        fixture.close_door(bench, compartment=part)
        fixture.close_door(bench, compartment=part, reg_type="drawer")


def _stove(bench: Bench) -> None:
    fixture, rng = bench.fixture, bench.rng
    knobs = fixture.get_knobs_state(bench)
    bench.ask(knobs, "no burner has a knob")
    for location in knobs:
        for mode, wanted in (("on", True), ("off", False)):
            fixture.set_knob_state(bench, rng, location, mode)
            bench.sim.forward()
            fixture.update_state(bench)
            follows = fixture.is_burner_on(bench, location) == wanted
            bench.ask(follows, f"knob of {location} turned {mode}: the burner does not follow")


def _follows(bench: Bench, name: str, value: float, found: Callable[[], float], off: float = 0.01) -> None:
    """What does not go where it was set, once the class has looked."""
    bench.fixture.update_state(bench)
    bench.ask(abs(found() - value) <= off, f"{name} does not go to {value:g}")


def _oven(bench: Bench) -> None:
    fixture = bench.fixture
    for level in (0, 1) if fixture.has_multiple_rack_levels() else (0,):
        for value in (1.0, 0.0):
            fixture.slide_rack(bench, value, level)
            _follows(bench, f"rack{level}", value, lambda n=level: fixture.get_state(n)[f"rack{n}"])
    for setter, name in ((fixture.set_timer, "timer"), (fixture.set_temperature, "temperature")):
        setter(bench, 0.5)
        _follows(bench, name, 0.5, lambda n=name: fixture.get_state()[n])
        setter(bench, 0.0)


def _toaster_oven(bench: Bench) -> None:
    fixture = bench.fixture
    for name in ("doneness", "function", "temperature", "time"):
        try:
            getattr(fixture, f"set_{name}")(bench, 0.5)
        except KeyError:
            bench.ask(False, f"set_{name}: there is no such knob")
            continue
        _follows(bench, name, 0.5, lambda n=name: getattr(fixture, f"_{n}"))
        getattr(fixture, f"set_{name}")(bench, 0.0)
    for value in (1.0, 0.0):
        slid = fixture.slide_rack(bench, value)
        _follows(bench, slid, value, lambda n=slid: fixture.get_state()[n])
    fixture.close_door(bench)


def _dishwasher(bench: Bench) -> None:
    for value in (1.0, 0.0):
        bench.fixture.slide_rack(bench, value)
        _follows(bench, "rack", value, lambda: bench.fixture.get_state(bench)["rack"])
    bench.fixture.close_door(bench)


def _press(bench: Bench, button: str, wanted: bool) -> None:
    bench.touch(f"{bench.fixture.naming_prefix}{button}")
    bench.touch(None)
    is_on = bench.fixture.get_state()["turned_on"]
    bench.ask(is_on == wanted, f"{button} does not turn it {'on' if wanted else 'off'}")


def _microwave(bench: Bench) -> None:
    fixture = bench.fixture
    for button, wanted in (("start_button", True), ("stop_button", False), ("start_button", True)):
        _press(bench, button, wanted)
    fixture.open_door(bench)
    bench.touch(None)
    bench.ask(not fixture.get_state()["turned_on"], "the open door does not turn it off")
    fixture.close_door(bench)


def _toaster(bench: Bench) -> None:
    fixture = bench.fixture
    for pair in fixture._slot_pairs:
        fixture.set_doneness_knob(bench, pair, 0.5)
        fixture.set_lever(bench, pair, 1.0)
        fixture.update_state(bench)
        state = fixture.get_state(bench, pair)
        is_on = state["turned_on"] and abs(state["knob"] - 0.5) <= 0.01
        bench.ask(is_on, f"the lever of pair {pair} does not turn it on: {state}")
    bench.ask(fixture._slot_pairs, "no pair of slots")


def _blender(bench: Bench) -> None:
    fixture = bench.fixture
    bench.ask(fixture.anchor_offset is not None, "anchor_offset is None")
    bench.ask(fixture.blender_lid is not None, "it has no lid")
    if fixture.anchor_offset is None or fixture.blender_lid is None:
        return
    bench.settle({})
    bench.touch(None)
    bench.ask(fixture.get_state()["lid_on_blender"], "a lid on its jar is not taken for one")
    for wanted in (True, False):
        _press(bench, "power_button_main", wanted)
    bench.data.qpos[bench.model.joint(f"{fixture.blender_lid.name}_joint0").qposadr[0] + 2] += 0.3
    bench.touch(None)
    bench.ask(not fixture.get_state()["lid_on_blender"], "a lid that was taken off is taken for one that is on")


def _coffee(bench: Bench) -> None:
    fixture = bench.fixture
    _press(bench, fixture._start_button_names[0], True)
    bench.ask(fixture._coffee_liquid_site_names, "no coffee is seen to flow")


def _kettle(bench: Bench) -> None:
    fixture = bench.fixture
    for value in (1.0, 0.0):
        fixture.set_lid(bench, value)
        _follows(bench, "lid", value, lambda: fixture.get_state(bench)["lid"], off=0.02)
    fixture.set_power_state(bench, True)
    fixture.update_state(bench)
    bench.ask(fixture.get_state(bench)["turned_on"], "the switch does not turn it on")


def _mixer(bench: Bench) -> None:
    fixture = bench.fixture
    for setter, name in ((fixture.set_head_pos, "head"), (fixture.set_speed_dial_knob, "speed_dial_knob")):
        for value in (1.0, 0.0):
            setter(bench, value)
            _follows(bench, name, value, lambda n=name: getattr(fixture, f"_{n}_value"))


def _sink(bench: Bench) -> None:
    fixture = bench.fixture
    for mode, wanted in (("on", True), ("off", False)):
        fixture.set_handle_state(bench, bench.rng, mode)
        bench.sim.forward()
        fixture.update_state(bench)
        follows = fixture.get_handle_state(bench)["water_on"] == wanted
        bench.ask(follows, f"the handle turned {mode}: the water does not follow")
    for low, wanted in ((0.0, "cold"), (0.8, "hot")):
        fixture.set_temp_state(bench, bench.rng, low, low + 0.2)
        bench.ask(fixture.get_handle_state(bench)["water_temp_state"] == wanted, f"the water is not {wanted}")
    water = bench.data.site(f"{fixture.naming_prefix}water").xpos - fixture.pos
    basins = fixture.get_int_sites().values()
    inside = any(all(box[0][i] < water[i] < box[i + 1][i] for i in range(2)) for box in basins)
    bench.ask(inside, f"the water of the resting spout falls at {water[:2].round(3).tolist()}, into no basin")


def places(bench: Bench, kind: str) -> Iterator[tuple[str, dict[str, Any], bool]]:
    """(title, reset regions, whether there have to be some): what the class answers where things are put."""
    fixture = bench.fixture
    if kind.startswith("Fridge"):
        yield "fridge", fixture.get_reset_regions(bench), True
        yield "fridge drawers", fixture.get_reset_regions(bench, reg_type="drawer", z_range=(0.0, 2.0)), False
        # RoboCasa puts nothing into a freezer that is at the bottom unless a task says what height it means.
        anywhere: dict[str, Any] = {"reg_type": ("shelf", "drawer"), "z_range": (0.0, 2.0)}
        yield "freezer", fixture.get_reset_regions(bench, "freezer", **anywhere), True
        yield "freezer, top", fixture.get_reset_regions(bench, "freezer", **anywhere, rack_index=-1), True
        return
    if kind in ("Oven", "ToasterOven"):
        for level in (0, 1):
            yield f"rack {level}", fixture.get_reset_regions(bench, rack_level=level), True
        return
    if kind == "Sink":
        yield "sink", fixture.get_reset_regions(bench), True
        if "basin_left" in fixture._regions:
            for side in ("left", "right"):
                yield side, fixture.get_reset_regions(bench, side=side), True
        return
    found = fixture.get_reset_regions(bench)
    # Nothing is put into a hood, a blender or a kettle.
    yield "all", found, kind not in ("Hood", "Blender", "ElectricKettle")


def drop(bench: Bench, kind: str, pulled: bool) -> None:
    fixture = bench.fixture
    fixture_utils = sys.modules["robocasa.utils.object_utils"]
    if pulled:
        for joint in [*fixture.door_joint_names, *_sliders(bench)]:
            fixture.set_joint_state(1.0, 1.0, bench, [joint])
        bench.sim.forward()
        if kind.startswith("Fridge"):
            fixture.update_state(bench)
    held = bench.joints()
    for title, regions, needed in places(bench, kind):
        bench.ask(regions or not needed, f"{title}: no reset region")
        started = {}
        for k, (name, region) in enumerate(regions.items()):
            edge = CUBE_M if min(region["size"]) < 0.02 else min(CUBE_M, 0.75 * min(region["size"]))
            bench.resize(k, edge)
            at = fixture_utils.get_pos_after_rel_offset(fixture, np.array(region["offset"]))
            if pulled and kind in ("Oven", "ToasterOven", "Dishwasher"):
                at = at + _moved(bench, name)
            started[name] = at + np.array([0.0, 0.0, edge / 2 + LIFT_M])
            bench.put(k, started[name])
        bench.settle(held)
        for k, (name, at) in enumerate(started.items()):
            off = bench.data.body(f"cube{k}").xpos - at
            way = "a pulled" if pulled else "a"
            told = f"{title}: a cube put into {way} {name} moves by {off.round(3).tolist()}"
            bench.ask(np.abs(off).max() <= STAYS_M, told)
            bench.put(k, np.array(_parked(k)))


def _sliders(bench: Bench) -> list[str]:
    return [j for j in bench.fixture._joint_infos if "rack" in j or "tray" in j or "drawer" in j]


def _moved(bench: Bench, region: str) -> np.ndarray:
    """How far a region is from where its element says, as Kitchen adds it to what stands on a rack."""
    element = bench.fixture._regions[region]["elem"]
    first = bench.fixture.pos + np.array([float(v) for v in element.get("pos").split()])
    return bench.data.geom(f"{bench.fixture.naming_prefix}reg_{region}").xpos - first


def misplaced(bench: Bench) -> None:
    """Regions that are not where the class takes them to be, with every joint at rest."""
    for name, region in bench.fixture._regions.items():
        said = bench.fixture.pos + (region["p0"] + region["px"] + region["py"] + region["pz"] - 2 * region["p0"]) / 2
        off = np.linalg.norm(bench.data.geom(f"{bench.fixture.naming_prefix}reg_{name}").xpos - said)
        bench.ask(off <= SAME_PLACE_M, f"region {name} is {1000 * off:.0f} mm from where it is taken to be")


def made(row: dict[str, str], folder: Path, fixtures: Any) -> Bench:
    kind, name = row["class"], row["name"]
    fixture = getattr(fixtures, kind)(xml=str(folder / row["folder"] / "model.xml"), name=name)
    low, height = fixture.bottom_offset[2], fixture.height
    if kind in LET_IN:
        z = WORKTOP - height - low
    else:
        floor = kind in ON_THE_FLOOR or kind.startswith("Fridge")
        z = HEIGHTS.get(kind, 0.0 if floor else WORKTOP) - low
    fixture.set_pos([0.0, 0.0, z])
    if "lid" not in row:
        return Bench(fixture)
    lid = fixtures.BlenderLid(xml=str(folder / row["lid"] / "model.xml"), name=f"{name}_lid")
    lid.set_pos(fixture.pos + (0.0 if fixture.anchor_offset is None else fixture.anchor_offset))
    fixture.add_auxiliary_fixture(lid)
    return Bench(fixture, lid)


def tell(row: dict[str, str], folder: Path, fixtures: Any) -> dict[str, Any]:
    bench = made(row, folder, fixtures)
    bench.sim.forward()
    misplaced(bench)
    operate(bench, row["class"])
    mujoco.mj_resetData(bench.model, bench.data)
    bench.sim.forward()
    for pulled in (False, True) if _sliders(bench) else (False,):
        drop(bench, row["class"], pulled)
    warnings = [mujoco.mjtWarning(i).name for i, w in enumerate(bench.data.warning) if w.number]
    return {"name": row["name"], "class": row["class"], "wrong": bench.wrong + warnings}


def main() -> None:
    task = Path(sys.argv[1])
    with contextlib.redirect_stdout(io.StringIO()):
        from robocasa.models import fixtures
    asked = json.loads(task.read_text(encoding="ascii"))
    told = []
    for row in asked["fixtures"]:
        try:
            told.append(tell(row, task.parent, fixtures))
        except Exception as error:  # noqa: BLE001  whatever a class raises is told, and the others go on
            told.append({"name": row["name"], "class": row["class"], "wrong": [f"{type(error).__name__}: {error}"]})
    takes_file = {
        name: "xml" in inspect.signature(getattr(fixtures, name).__init__).parameters for name in asked["classes"]
    }
    print(json.dumps({"mujoco": mujoco.__version__, "fixtures": told, "takes_file": takes_file}))


if __name__ == "__main__":
    main()
