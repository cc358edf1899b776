"""Runs the tasks of RoboCasa v1.0 in the kitchens of this folder; nothing of RoboCasa's source is changed.

    import sys

    sys.path.insert(0, "<this folder>")
    import casa_kitchens
    import robosuite

    casa_kitchens.register()  # ('l_small__coastal', ...)
    pairs = casa_kitchens.layout_and_style_ids("l_small__coastal")  # without an id: all, and RoboCasa draws one
    env = robosuite.make("OpenDrawer", robots="PandaOmron", layout_and_style_ids=pairs, seed=0, ...)

RoboCasa knows a kitchen by one number, as layout and as style. `register` replaces three names in modules of RoboCasa:
the arena, the sampler of fixtures and the path of a layout. Each asks whether a kitchen is one of these and otherwise
does what it did; `unregister` puts the old ones back. Nothing but RoboCasa and the standard library is needed.
"""

from __future__ import annotations

import copy
import importlib
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
INDEX = "kitchens.json"
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
# Where on a worktop RoboCasa looks for room for the lid of a blender that is to be put on: round the blender, in front.
LID_ON_WORKTOP = {"size": (0.7, 0.4), "pos": ("ref", -1.0), "rotation": (0.0, 0.0)}

_kitchens: dict[int, Path] = {}  # number -> folder of the kitchen
_numbers: dict[str, int] = {}
_replaced: list[tuple[Any, str, Any]] = []  # module, name, what stood there
_classes: dict[str, Any] = {}


def register(root: Path | str = HERE) -> tuple[str, ...]:
    """Let RoboCasa open the kitchens of an export. May be called again, and for several exports.

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
    """Put back what `register` replaced and forget all kitchens."""
    while _replaced:
        module, name, original = _replaced.pop()
        setattr(module, name, original)
    _kitchens.clear()
    _numbers.clear()


def ids() -> tuple[str, ...]:
    """Ids of all kitchens that are registered."""
    return tuple(_numbers)


def layout_and_style_ids(*names: str) -> list[list[int]]:
    """What RoboCasa's argument of this name is for some kitchens, by their ids; for all of them where none is named.

    Of several RoboCasa draws one at each reset, by the seed of the environment.

    Raises:
        KeyError: a kitchen is not registered.
    """
    for name in names:
        if name not in _numbers:
            raise KeyError(f"no kitchen {name!r} is registered; there are {', '.join(_numbers) or 'none'}")
    return [[_numbers[name], _numbers[name]] for name in names or _numbers]


def tasks_of(name: str) -> tuple[str, ...]:
    """The atomic tasks of RoboCasa that a kitchen has all fixtures for, as `scene.json` says, by their names.

    Raises:
        KeyError: the kitchen is not registered.
    """
    [[number, _]] = layout_and_style_ids(name)
    return tuple(json.loads((_kitchens[number] / "kitchen.json").read_text(encoding="ascii"))["tasks"])


def kitchen_of(env: Any) -> str:
    """Id of the kitchen in which an environment is. Raises KeyError where it is none of these."""
    return _kitchens[int(env.layout_id)].name


def _module(name: str) -> Any:
    return importlib.import_module(name)


def _replace(module: Any, name: str, make: Callable[[Any], Any]) -> None:
    """Put what `make` makes of the original in its place."""
    original = getattr(module, name)
    _replaced.append((module, name, original))
    setattr(module, name, make(original))


def _folder_of(layout_id: Any) -> Path | None:
    """Folder of one of these kitchens, None where a layout is RoboCasa's."""
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
    """In place of a sampler: fixtures stay where the kitchen has them; what stands on worktops is told to RoboCasa."""

    def __init__(self, fixtures: Sequence[Any]) -> None:
        self.fixtures = [fixture for fixture in fixtures if fixture.casa["is_standing"]]

    def sample(self, placed_objects: Any = None, **_: Any) -> dict[str, Any]:
        """Name -> (position, quaternion (w, x, y, z), fixture), whatever else is placed."""
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
    """Reads the arena and the fixtures of a kitchen; mixed with robosuite's Arena."""

    def __init__(self, folder: Path, rng: Any, lids: dict[str, Any]) -> None:
        """`lids` is what a task asks of the lids of blenders: none, beside the blender, or else on it."""
        _module("robosuite.models.arenas").Arena.__init__(self, str(folder / "arena.xml"))
        description = json.loads((folder / "kitchen.json").read_text(encoding="ascii"))
        root = folder.parent.parent
        rows = [row for row in description["fixtures"] if not row["lid_of"] or lids.get("enable", True)]
        self.fixtures = {row["name"]: _fixture(row, root, rng) for row in rows}
        for lid in (self.fixtures[row["name"]] for row in rows if row["lid_of"]):
            blender = self.fixtures[lid.casa["lid_of"]]
            blender.add_auxiliary_fixture(lid)
            lid.blender = blender if lids.get("placement") == "parent_region" else None

    def get_fixture_cfgs(self) -> list[dict[str, Any]]:
        """Rows as RoboCasa's own arena has them."""
        return [{"name": name, "model": made, "type": "fixture"} for name, made in self.fixtures.items()]


def _fixture(row: dict[str, Any], root: Path, rng: Any) -> Any:
    """A fixture of a description, at its place."""
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
    """Meshes, images and materials of our files are named by their content: fixtures share them in one model."""

    def __init__(self, *args: Any, casa: dict[str, Any], **kwargs: Any) -> None:
        self.casa = casa
        super().__init__(*args, **kwargs)

    def exclude_from_prefixing(self, inp: Any) -> bool:
        """True for the elements and names of such assets."""
        if not isinstance(inp, str):
            return inp.tag in ("mesh", "texture", "material")
        if "_asset_names" not in self.__dict__:
            self._asset_names = {element.get("name") for element in self.asset}  # type: ignore[attr-defined]
        return inp in self._asset_names


class _FromFile(_SharedAssets):
    """Loads a file in place of a class of RoboCasa that builds itself."""

    def __init__(self, xml: str, name: str, rng: Any, casa: dict[str, Any], joints: Any = None) -> None:
        self.casa = casa
        for key, value in {**ATTRIBUTES.get(casa["class"], {}), **casa["facts"]}.items():
            setattr(self, key, value)
        _module("robocasa.models.fixtures").Fixture.__init__(
            self, xml=xml, name=name, duplicate_collision_geoms=False, rng=rng, joints=joints
        )

    def _add_init_elements(self) -> None:
        """The file has all regions."""

    @property
    def width(self) -> Any:
        """Of the region `main`, m, as of every fixture out of a file."""
        return _module("robocasa.models.fixtures").Fixture.width.fget(self)

    @property
    def depth(self) -> Any:
        """Of the region `main`, m."""
        return _module("robocasa.models.fixtures").Fixture.depth.fget(self)

    @property
    def height(self) -> Any:
        """Of the region `main`, m."""
        return _module("robocasa.models.fixtures").Fixture.height.fget(self)

    def _get_counter_geoms(self) -> dict[str, list[Any]]:
        """Free surfaces of a worktop under names that begin with `top`, as a counter asks for them."""
        element = _module("xml.etree.ElementTree").Element
        found = {}
        for number, row in enumerate(self.casa["facts"]["surfaces"]):
            half = [length / 2 for length in row["size"]]
            values = {"pos": " ".join(map(str, row["position"])), "size": " ".join(map(str, half))}
            found[f"top_{number}"] = [element("geom", values)]
        return found


class _RoomPart(_FromFile):
    """A floor or a wall out of a file. RoboCasa's are generated boxes, whose names are made otherwise."""

    def _get_object_properties(self) -> None:
        objects, tools = _module("robosuite.models.objects"), _module("robosuite.utils.mjcf_utils")
        objects.MujocoObject._get_object_properties(self)
        tools.add_prefix(root=self.root, prefix=self.naming_prefix, exclude=self.exclude_from_prefixing)  # type: ignore[attr-defined]


def _class(name: str) -> Any:
    """A class of ours, called like the one of RoboCasa that it stands for: RoboCasa tells some by their names."""
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
