"""Runs the tasks of RoboCasa v1.0 in the kitchens of this folder, without changes to RoboCasa's source.

    import sys

    sys.path.insert(0, "<this folder>")
    import casa_kitchens
    import robosuite

    casa_kitchens.patch_robosuite()  # RoboCasa v1.0 on the robosuite 1.5.2 that pip installs
    casa_kitchens.register()  # ('l_small__coastal', ...)
    pairs = casa_kitchens.layout_and_style_ids("l_small__coastal")  # without an id: all, and RoboCasa draws one
    env = robosuite.make("OpenDrawer", robots="PandaOmron", layout_and_style_ids=pairs, seed=0, ...)

RoboCasa identifies a kitchen by one number, as layout and as style. `register` replaces three names in modules of
RoboCasa: the arena, the sampler of fixtures and the path of a layout. Each replacement handles the kitchens of this
folder and calls the original for all others; `unregister` restores the originals. Only RoboCasa and the standard
library are needed.
"""

from __future__ import annotations

import copy
import importlib
import inspect
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
INDEX = "kitchens.json"
STATES = "start_states.npz"
MOBILE_JOINTS = ("forward", "side", "yaw")
# Classes of RoboCasa that build themselves of boxes: ours load a file in their place.
BUILT_BY_ROBOCASA = (
    *("HingeCabinet", "SingleCabinet", "OpenCabinet", "PanelCabinet", "HousingCabinet", "Drawer", "Counter"),
    *("Accessory", "WallAccessory", "Stool", "Window"),
)
ROOM = ("Floor", "Wall")
# Attributes that these classes make of their arguments, where RoboCasa reads them later.
_ON_A_WALL = {"wall": None, "protrusion": None}
_OF_A_ROOM = {"wall_side": None, "enclosing_wall": False}
_COUNTER = {"interior_obj": None, "has_opening": False, "half_top": [False, False], "hollow": [False, True]}
ATTRIBUTES: dict[str, dict[str, Any]] = {
    "HousingCabinet": {"interior_obj": None},
    "Counter": {**_COUNTER, "overhang": 0.0, "th": 0.03},
    "Accessory": {"is_clutter": False},
    **dict.fromkeys(("WallAccessory", "Stool", "Window"), _ON_A_WALL),
    **dict.fromkeys(ROOM, _OF_A_ROOM),
}
FREE_JOINT = {"type": "free", "damping": "0.0005"}
# Called by `MujocoEnv.__init__` of robosuite 1.5.2 after it has stored its arguments; `reset` calls all of them again.
LOADING = ("_load_model", "_initialize_sim", "initialize_renderer", "_reset_internal", "_setup_observables")
# Where on a worktop RoboCasa looks for room for the lid of a blender that is to be put on: round the blender, in front.
LID_ON_WORKTOP = {"size": (0.7, 0.4), "pos": ("ref", -1.0), "rotation": (0.0, 0.0)}

_kitchens: dict[int, Path] = {}  # number -> folder of the kitchen
_numbers: dict[str, int] = {}
_replaced: list[tuple[Any, str, Any]] = []  # module, name, what stood there
_classes: dict[str, Any] = {}
_states: dict[Path, dict[str, Any]] = {}  # what was read of files of start states
_begin: list[int | str] = []  # what `begin_with` was given; empty for None


def register(root: Path | str = HERE) -> tuple[str, ...]:
    """Let RoboCasa open the kitchens of an export. May be called repeatedly, and for several exports.

    Returns:
        Ids of the kitchens of this export.
    """
    root = Path(root).resolve()
    index = json.loads((root / INDEX).read_text(encoding="ascii"))
    for name, number in index["kitchens"].items():
        _kitchens[number] = root / "kitchens" / name
        _numbers[name] = number
    if not _replaced:
        kitchen = _module("robocasa.environments.kitchen.kitchen")
        _replace(kitchen, "KitchenArena", _arena_for)
        _replace(kitchen.EnvUtils, "get_single_fixture_sampler", _sampler_for)
        _replace(_module("robocasa.models.scenes.scene_registry"), "get_layout_path", _layout_path_for)
    return tuple(index["kitchens"])


def unregister() -> None:
    """Restore the names that `register` replaced, and forget all kitchens."""
    while _replaced:
        module, name, original = _replaced.pop()
        setattr(module, name, original)
    for known in (_kitchens, _numbers, _states, _begin):
        known.clear()


def patch_robosuite() -> tuple[str, ...]:
    """Add to robosuite the features that RoboCasa v1.0 needs and release 1.5.2 on PyPI lacks; its main branch has them.

    RoboCasa v1.0 calls robosuite with `load_model_on_init`, `enable_multiccd` and the controller
    `JOINT_VELOCITY_LEGACY`: without these, `robosuite.make` raises a TypeError. Each is added only if it is missing, in
    memory: no file is changed, and it is safe to call this twice. Call it before the first environment is made.

    Returns:
        Names of the added features; empty if robosuite had them all.
    """
    environment = _module("robosuite.environments.manipulation.manipulation_env").ManipulationEnv
    task = _module("robosuite.models.tasks").ManipulationTask
    factory = _module("robosuite.controllers.parts.controller_factory")
    added = []
    if "load_model_on_init" not in inspect.signature(environment.__init__).parameters:
        environment.__init__ = _loading_on_reset(environment.__init__)
        base = _module("robosuite.environments.base").MujocoEnv
        base.sim = None  # `reset` reads it before the first model is made
        added.append("load_model_on_init")
    if "enable_multiccd" not in inspect.signature(task.__init__).parameters:
        task.__init__ = _with_multiccd(task.__init__)
        added.append("enable_multiccd")
    if "JOINT_VELOCITY_LEGACY" not in inspect.getsource(factory.mobile_base_controller_factory):
        factory.mobile_base_controller_factory = _with_legacy_base(factory.mobile_base_controller_factory)
        added.append("JOINT_VELOCITY_LEGACY")
    return tuple(added)


def _loading_on_reset(original: Any) -> Any:
    """Support `load_model_on_init=False`: the model is made by `reset` and not by the constructor."""

    def init(self: Any, *arguments: Any, load_model_on_init: bool = True, **keywords: Any) -> None:
        if not load_model_on_init:
            vars(self).update(dict.fromkeys(LOADING, dict))  # calls that do nothing; robosuite asks for a dictionary
        original(self, *arguments, **keywords)
        if not load_model_on_init:
            for name in LOADING:
                delattr(self, name)

    return init


def _with_multiccd(original: Any) -> Any:
    """Support `enable_multiccd`: several contacts between two meshes. MuJoCo 3.3.1 has no sleeping islands."""

    def init(
        self: Any,
        *arguments: Any,
        enable_multiccd: bool = False,
        enable_sleeping_islands: bool = False,
        **keywords: Any,
    ) -> None:
        if enable_sleeping_islands:
            raise ValueError("enable_sleeping_islands needs a newer robosuite than this one and a newer MuJoCo")
        original(self, *arguments, **keywords)
        if enable_multiccd:
            option = _module("robosuite.utils.mjcf_utils").find_elements(self.root, "option", return_first=True)
            option.append(_module("xml.etree.ElementTree").Element("flag", {"multiccd": "enable"}))

    return init


def _with_legacy_base(original: Any) -> Any:
    """Accept `JOINT_VELOCITY_LEGACY`, the new name of robosuite 1.5.2's `JOINT_VELOCITY`."""

    def mobile_base_controller_factory(name: str, params: Any) -> Any:
        return original("JOINT_VELOCITY" if name == "JOINT_VELOCITY_LEGACY" else name, params)

    return mobile_base_controller_factory


def ids() -> tuple[str, ...]:
    """Ids of all registered kitchens."""
    return tuple(_numbers)


def layout_and_style_ids(*names: str) -> list[list[int]]:
    """Return RoboCasa's argument of this name for some kitchens, by their ids, or for all kitchens if no id is given.

    If there are several, RoboCasa draws one at each reset, by the seed of the environment.

    Raises:
        KeyError: a kitchen is not registered.
    """
    for name in names:
        if name not in _numbers:
            raise KeyError(f"no kitchen {name!r} is registered; there are {', '.join(_numbers) or 'none'}")
    return [[_numbers[name], _numbers[name]] for name in names or _numbers]


def tasks_of(name: str) -> tuple[str, ...]:
    """Names of the atomic tasks of RoboCasa for which a kitchen has all fixtures, according to `scene.json`.

    Raises:
        KeyError: the kitchen is not registered.
    """
    [[number, _]] = layout_and_style_ids(name)
    return tuple(json.loads((_kitchens[number] / "kitchen.json").read_text(encoding="ascii"))["tasks"])


def kitchen_of(env: Any) -> str:
    """Id of the kitchen of an environment. Raises KeyError if it is not a registered kitchen."""
    return _kitchens[int(env.layout_id)].name


def start_states(name: str) -> dict[str, Any]:
    """Return the start states of a kitchen that was exported with them: `qpos`, `base`, `notes` and more.

    Names of joints are those of RoboCasa's model. Fields: docs/howto/kitchens/start_states.md of casa_assets.

    Raises:
        KeyError: the kitchen is not registered, or has no start states.
    """
    [[number, _]] = layout_and_style_ids(name)
    path = _kitchens[number] / STATES
    if path not in _states:
        if not path.is_file():
            raise KeyError(f"{name!r} was exported without start states; give --states")
        with _module("numpy").load(path, allow_pickle=False) as found:
            arrays = {key: found[key] for key in found.files}
        _states[path] = {**json.loads(bytes(arrays.pop("header"))), **arrays}
    return _states[path]


def begin_with(number: int | str | None) -> None:
    """Let each reset put the loose objects of a kitchen where they are in one of its start states.

    RoboCasa then places its own objects around them, and parks its robot where the task requires it. Doors begin
    closed.

    Args:
        number: number of the state; "random": drawn by the environment's seed; None: the poses in the kitchen. A
            kitchen without start states is not changed.
    """
    _begin.clear()
    if number is not None:
        _begin.append(number)


def reset_to(env: Any, number: int, parks: bool = True) -> None:
    """Put a kitchen into one of its start states; call it after `env.reset()`.

    Objects of a task are not moved, so they may now overlap with objects of the state: `begin_with` lets RoboCasa find
    other places for them.

    Args:
        number: number of the state.
        parks: also move the base of a robot with wheels to the pose in the state.
    Raises:
        KeyError: the kitchen has no start states, or is not a registered kitchen. IndexError: there is no such state.
    """
    name = kitchen_of(env)
    states = start_states(name)
    columns, addresses = _columns_of(env, name, states)
    env.sim.data.qpos[addresses] = states["qpos"][number][columns]
    env.sim.data.qvel[:] = 0.0
    if parks:
        _park(env, *(float(value) for value in states["base"][number]))
    env.sim.forward()


def _columns_of(env: Any, name: str, states: dict[str, Any]) -> tuple[list[int], list[int]]:
    """Columns of a row that the model of an environment has, and their indices in its qpos; cached per model."""
    model = env.sim.model
    kept = getattr(env, "_casa_columns", None)
    if kept is not None and kept[0] is model:
        return kept[1], kept[2]
    [[number, _]] = layout_and_style_ids(name)
    rows = json.loads((_kitchens[number] / "kitchen.json").read_text(encoding="ascii"))["fixtures"]
    left_out = tuple(f"{row['name']}_" for row in rows if row["lid_of"])  # tasks leave lids of blenders out
    known = {model.joint_id2name(i): int(model.jnt_qposadr[i]) for i in range(model.njnt)}
    columns: list[int] = []
    addresses: list[int] = []
    for joint in states["joints"]:
        if joint["name"] in known:
            columns += range(joint["address"], joint["address"] + joint["width"])
            addresses += range(known[joint["name"]], known[joint["name"]] + joint["width"])
        elif not joint["name"].startswith(left_out):
            raise KeyError(f"there is no joint {joint['name']!r} in the environment: its kitchen is of another export")
    env._casa_columns = (model, columns, addresses)
    return columns, addresses


def _park(env: Any, x: float, y: float, yaw: float) -> None:
    """Move the frame of a mobile base, which is in its middle, to x, y (m), rotated by `yaw` (rad)."""
    array, model = _module("numpy").array, env.sim.model
    forward, side, turning = (model.joint_name2id(f"mobilebase0_joint_mobile_{way}") for way in MOBILE_JOINTS)
    root = model.body_parentid[model.jnt_bodyid[turning]]
    place, turned = env.sim.data.body_xpos[root], env.sim.data.body_xmat[root].reshape(3, 3)
    angle = (yaw - math.atan2(turned[1, 0], turned[0, 0]) + math.pi) % (2 * math.pi) - math.pi
    # The base turns about an axis beside its frame.
    (ax, ay, _), cosine, sine = model.jnt_pos[turning], math.cos(angle), math.sin(angle)
    aside = array([ax - cosine * ax + sine * ay, ay - sine * ax - cosine * ay, 0.0])
    wanted = turned.T @ (array([x, y, place[2]]) - place) - aside
    values = {
        forward: model.jnt_axis[forward] @ wanted,
        side: model.jnt_axis[side] @ wanted,
        turning: angle,
    }
    for joint, value in values.items():
        env.sim.data.qpos[model.jnt_qposadr[joint]] = value


def _begun(rows: list[dict[str, Any]], folder: Path, rng: Any) -> list[dict[str, Any]]:
    """Rows of fixtures, with loose objects in the poses of a start state and marked for the sampler of objects."""
    if not _begin or not (folder / STATES).is_file():
        return rows
    states = start_states(folder.name)
    number = int(rng.integers(len(states["qpos"]))) if _begin[0] == "random" else int(_begin[0])
    poses = {
        joint["name"]: states["qpos"][number][joint["address"] : joint["address"] + 7].astype(float).tolist()
        for joint in states["joints"]
        if joint["width"] > 1
    }
    found = []
    for row in rows:
        pose = poses.get(f"{row['name']}_joint0")
        moved = {} if pose is None else {"position": pose[:3], "quaternion": pose[3:], "is_standing": True}
        found.append({**row, **moved})
    return found


def _module(name: str) -> Any:
    return importlib.import_module(name)


def _replace(module: Any, name: str, make: Callable[[Any], Any]) -> None:
    """Replace a name in a module by the result of `make` for the original."""
    original = getattr(module, name)
    _replaced.append((module, name, original))
    setattr(module, name, make(original))


def _folder_of(layout_id: Any) -> Path | None:
    """Folder of a registered kitchen, or None for a layout of RoboCasa."""
    return None if isinstance(layout_id, dict) else _kitchens.get(int(layout_id))


def _arena_for(original: Any) -> Any:
    def make(layout_id: Any, style_id: Any, rng: Any = None, **options: Any) -> Any:
        folder = _folder_of(layout_id)
        if folder is None:
            return original(layout_id=layout_id, style_id=style_id, rng=rng, **options)
        blenders = (options.get("update_fxtr_cfg_dict") or {}).get("blender", {})
        return _class("Arena")(folder, rng, blenders.get("aux_fixture_config", {}))

    return make


def _sampler_for(original: Any) -> Any:
    def make(env: Any, cfg: Any, *args: Any, **kwargs: Any) -> Any:
        if _folder_of(env.layout_id) is None:
            return original(env, cfg, *args, **kwargs)
        if blender := getattr(cfg["model"] if isinstance(cfg, dict) else None, "blender", None):
            counter = env.get_fixture(_module("robocasa.models.fixtures").FixtureType.COUNTER, ref=blender)
            placement = {"fixture": counter, "sample_region_kwargs": {"ref": blender}, **LID_ON_WORKTOP}
            return original(env, {**cfg, "placement": placement}, *args, **kwargs)
        return _Standing([env.fixtures[c["name"]] for c in (cfg if isinstance(cfg, list) else [cfg])])

    return make


def _layout_path_for(original: Any) -> Any:
    def make(layout_id: Any) -> Any:
        folder = _folder_of(layout_id)
        return original(layout_id) if folder is None else str(folder / "layout.yaml")

    return make


class _Standing:
    """Replaces a sampler: fixtures keep their poses, and RoboCasa gets the list of those that are on worktops."""

    def __init__(self, fixtures: Sequence[Any]) -> None:
        self.fixtures = [fixture for fixture in fixtures if fixture.casa["is_standing"]]

    def sample(self, placed_objects: Any = None, **_: Any) -> dict[str, Any]:
        """Name -> (position, quaternion (w, x, y, z), fixture), regardless of other placed objects."""
        array = _module("numpy").array
        return {f.name: (tuple(f.casa["position"]), array(f.casa["quaternion"]), _foot_of(f)) for f in self.fixtures}


def _foot_of(fixture: Any) -> Any:
    """A fixture whose box ends below its trays: the worktop under it stays free, and a plate inside may be filled."""
    foot = copy.copy(fixture)

    def points(trans: Any = None, rot: Any = None) -> list[Any]:
        corners = fixture.get_bbox_points(trans=trans, rot=rot)
        top = min(float(corner[2]) for corner in corners) + fixture.casa["solid_height"]
        return [_module("numpy").array([x, y, min(float(z), top)]) for x, y, z in corners]

    foot.get_bbox_points = points
    return foot


class _ArenaParts:
    """Reads the arena and the fixtures of a kitchen; a mixin for robosuite's Arena."""

    def __init__(self, folder: Path, rng: Any, lids: dict[str, Any]) -> None:
        """`lids`: a task's options for the lids of blenders: left out, next to the blender, or else on it."""
        _module("robosuite.models.arenas").Arena.__init__(self, str(folder / "arena.xml"))
        description = json.loads((folder / "kitchen.json").read_text(encoding="ascii"))
        root = folder.parent.parent
        every = _begun(description["fixtures"], folder, rng)
        rows = [row for row in every if not row["lid_of"] or lids.get("enable", True)]
        self.fixtures = {row["name"]: _fixture(row, root, rng) for row in rows}
        for lid in (self.fixtures[row["name"]] for row in rows if row["lid_of"]):
            blender = self.fixtures[lid.casa["lid_of"]]
            blender.add_auxiliary_fixture(lid)
            lid.blender = blender if lids.get("placement") == "parent_region" else None

    def get_fixture_cfgs(self) -> list[dict[str, Any]]:
        """Rows as in RoboCasa's own arena."""
        return [{"name": name, "model": made, "type": "fixture"} for name, made in self.fixtures.items()]


def _fixture(row: dict[str, Any], root: Path, rng: Any) -> Any:
    """A fixture of a description, in its pose."""
    options: dict[str, Any] = {"joints": [dict(FREE_JOINT)]} if row["is_free"] else {}
    kind = _class(row["class"])
    made = kind(xml=str(root / row["model"]), name=row["name"], rng=rng, casa=row, **options)
    made.set_pos(row["position"])
    w, x, y, z = row["quaternion"]
    if abs(x) < 1e-9 and abs(y) < 1e-9:
        made.set_euler([0.0, 0.0, 2 * math.atan2(z, w)])
    else:
        made.get_obj().set("quat", " ".join(map(str, row["quaternion"])))
    return made


class _SharedAssets:
    """Mixin for fixtures that share meshes, images and materials in one model, since these are named by content."""

    def __init__(self, *args: Any, casa: dict[str, Any], **kwargs: Any) -> None:
        self.casa = casa
        super().__init__(*args, **kwargs)

    def set_euler(self, euler: Any) -> None:
        """Set the angles, unless the fixture has a quaternion: RoboCasa's order of angles differs from MuJoCo's."""
        if self.get_obj().get("quat") is None:  # type: ignore[attr-defined]
            super().set_euler(euler)  # type: ignore[misc]

    def exclude_from_prefixing(self, inp: Any) -> bool:
        """True for the elements and names of these assets."""
        if not isinstance(inp, str):
            return inp.tag in ("mesh", "texture", "material")
        if "_asset_names" not in self.__dict__:
            self._asset_names = {element.get("name") for element in self.asset}  # type: ignore[attr-defined]
        return inp in self._asset_names


def _size(name: str) -> property:
    return property(lambda self: getattr(_module("robocasa.models.fixtures").Fixture, name).fget(self))


class _FromFile(_SharedAssets):
    """Loads a file instead of a class of RoboCasa that builds its own geometry."""

    def __init__(self, xml: str, name: str, rng: Any, casa: dict[str, Any], joints: Any = None) -> None:
        self.casa = casa
        for key, value in {**ATTRIBUTES.get(casa["class"], {}), **casa["facts"]}.items():
            setattr(self, key, value)
        _module("robocasa.models.fixtures").Fixture.__init__(
            self, xml=xml, name=name, duplicate_collision_geoms=False, rng=rng, joints=joints
        )

    def _add_init_elements(self) -> None:
        """Do nothing: the file has all regions."""

    # Of the region `main`, m, as for every fixture that is loaded from a file.
    width, depth, height = (_size(name) for name in ("width", "depth", "height"))

    def _get_counter_geoms(self) -> dict[str, list[Any]]:
        """Free surfaces of a worktop with names that begin with `top`, as a counter expects them."""
        element = _module("xml.etree.ElementTree").Element
        found = {}
        for number, row in enumerate(self.casa["facts"]["surfaces"]):
            half = [length / 2 for length in row["size"]]
            values = {"pos": " ".join(map(str, row["position"])), "size": " ".join(map(str, half))}
            found[f"top_{number}"] = [element("geom", values)]
        return found


class _RoomPart(_FromFile):
    """A floor or a wall from a file. RoboCasa's own are generated boxes with another naming scheme."""

    def _get_object_properties(self) -> None:
        objects, tools = _module("robosuite.models.objects"), _module("robosuite.utils.mjcf_utils")
        objects.MujocoObject._get_object_properties(self)
        tools.add_prefix(root=self.root, prefix=self.naming_prefix, exclude=self.exclude_from_prefixing)  # type: ignore[attr-defined]


def _class(name: str) -> Any:
    """Return our class with the name of the RoboCasa class that it replaces: RoboCasa recognises some by name."""
    if name not in _classes:
        fixtures = _module("robocasa.models.fixtures")
        if name == "Arena":
            bases: tuple[Any, ...] = (_ArenaParts, _module("robosuite.models.arenas").Arena)
        elif name in ROOM:
            bases = (_RoomPart, fixtures.Fixture, getattr(fixtures, name))
        elif name in BUILT_BY_ROBOCASA or name == "Fixture":
            bases = (_FromFile, getattr(fixtures, name))
        else:
            bases = (_SharedAssets, getattr(fixtures, name))
        _classes[name] = type(name, bases, {"__module__": __name__})
    return _classes[name]
