"""Names that runtimes expect of the parts of an appliance, by its kind.

Ref: registry/contracts, and the fixture classes of RoboCasa that they were read from.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind, PartPlan, round7_vec3
from casa_assets.articulate.runtime.places import Burner, find_burners, link_bounds
from casa_assets.articulate.runtime.semantics import annotate_for_runtime, is_cabinet
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Joint, JointKind, Link, Region
from casa_assets.model.pose import Pose

# Two keys are in one row if their heights differ by less than this share of the taller one.
SAME_ROW_SHARE = 0.6
# Doors and drawers whose ranges runtimes read as -a..0 or 0..a about +x, +y or +z.
_PLAIN_AXES = frozenset({PartKind.DOOR, PartKind.DRAWER, PartKind.TRAY, PartKind.LEVER})
# Labels of visuals that protrude from the box by which runtimes place an object.
_OUTSIDE = frozenset({"handle", "knob", "button", "lever"})
# Range of a knob with settings. Ref: RoboCasa v1.0, class Stove: less than 2 pi - 0.35.
KNOB_SETTING_RANGE_RAD = math.radians(300)
# An axis within 3 degrees of x, y or z is snapped to it: loaders that scale fixtures handle no other.
AXIS_SNAP_COS = math.cos(math.radians(3))


@dataclass(frozen=True)
class RuntimeName:
    """Names of a part: of its link, its joint, and its first collider if that has a separate name."""

    link: str
    joint: str
    shape: str = ""


@dataclass(frozen=True)
class PlacedPart:
    """A part with the middle and size of its visuals: right, back, up; metres."""

    part: PartPlan
    middle: Floats
    size: Floats


NamesByPart = dict[str, RuntimeName]


def runtime_names(places: Sequence[PlacedPart], category: str, burners: Sequence[Burner] = ()) -> NamesByPart:
    """Return the runtime names of the parts that a category names, by part name; burners are those on its top."""
    namers = {
        "microwave": _microwave,
        "refrigerator": _fridge,
        "fridge": _fridge,
        "dishwasher": _folding,
        "toaster": _toaster,
        "coffee_machine": _coffee_machine,
        "kettle": _kettle,
        "sink": _faucet,
    }
    if category in namers:
        return namers[category](places)
    if category in ("wall_oven", "toaster_oven", "oven"):
        return _folding(places) | _settings(places, category)
    if category in ("range", "hob"):
        has_oven = category == "range"
        return (_folding(places) if has_oven else {}) | _hob(places, burners, has_oven)
    return _cabinet(places) if is_cabinet(category) else {}


def _named(place: PlacedPart, link: str, joint: str = "", shape: str = "") -> NamesByPart:
    return {place.part.name: RuntimeName(link, joint or f"{link}_joint", shape)}


def _microwave(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name the door, the turntable, and the start and stop keys: the lowest ones, stop to the left of start."""
    names: dict[str, RuntimeName] = {}
    doors = _on_body(places, PartKind.DOOR)
    if len(doors) == 1:
        names |= _named(doors[0], "door", "microjoint")
    for disc in (p for p in _on_body(places, PartKind.TRAY) if p.part.joint.endless):
        names |= _named(disc, "tray", shape="tray") if "tray" not in [n.link for n in names.values()] else {}
    keys = sorted(
        (p for p in places if p.part.kind is PartKind.BUTTON), key=lambda p: (_coordinate(p, 2), -_coordinate(p, 0))
    )
    if len(keys) > 1:
        row = [k for k in keys if k.middle[2] - keys[0].middle[2] <= SAME_ROW_SHARE * max(k.size[2], keys[0].size[2])]
        start = max(row, key=lambda p: _coordinate(p, 0))
        stop = min(row, key=lambda p: _coordinate(p, 0)) if len(row) > 1 else keys[1]
        names |= _named(start, "start_button", shape="start_button") | _named(stop, "stop_button", shape="stop_button")
    return names


def _folding(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name doors from above, and racks from below, so that rack1 of a dishwasher is the upper one."""
    doors = sorted(_on_body(places, PartKind.DOOR), key=lambda p: -_coordinate(p, 2))
    names: dict[str, RuntimeName] = {}
    words = [""] if len(doors) == 1 else ["upper_", "lower_"] if len(doors) == 2 else []
    for word, door in zip(words, doors, strict=False):
        names |= _named(door, f"{word}door")
    racks = [p for p in _on_body(places, PartKind.TRAY) if p.part.joint.kind is JointKind.SLIDE]
    for i, rack in enumerate(sorted(racks, key=lambda p: _coordinate(p, 2))[:6]):
        names |= _named(rack, f"rack{i}")
    return names


def _settings(places: Sequence[PlacedPart], category: str) -> NamesByPart:
    """Name the knobs of an oven, from the left or from above: temperature, function, time."""
    knobs = _sorted_in_line(_on_body(places, PartKind.KNOB))
    words = {2: ("temp", "time"), 3: ("temp", "function", "time"), 4: ("temp", "function", "doneness", "time")}
    if category == "wall_oven":
        words = {2: words[2], 3: words[3]}
    names: dict[str, RuntimeName] = {}
    for word, knob in zip(words.get(len(knobs), ()), knobs, strict=False):
        names |= _named(knob, f"knob_{word}")
    return names


def _hob(places: Sequence[PlacedPart], burners: Sequence[Burner], has_oven: bool) -> NamesByPart:
    """Name a knob for each burner: of a row from left to right, of a column from the far end.

    Of the two burners of a side, the front one belongs to the outer knob. Surplus knobs in the middle of the row belong
    to the oven; without an oven, some burner was not found, and no knob is named.
    """
    knobs = _sorted_in_line(_on_body(places, PartKind.KNOB))
    spare = len(knobs) - len(burners)
    if not burners or spare < 0 or (spare and not has_oven):
        return {}
    names: dict[str, RuntimeName] = {}
    left_count = (len(knobs) - spare + 1) // 2
    for word, knob in zip(("temp", "time", "function"), knobs[left_count : left_count + spare], strict=False):
        names |= _named(knob, f"knob_{word}")
    burner_knobs = knobs[:left_count] + knobs[left_count + spare :]
    span = np.ptp([k.middle for k in burner_knobs], axis=0)
    middle = float(np.mean([b.middle[0] for b in burners]))
    if span[0] >= span[1]:
        ordered = sorted(burners, key=lambda b: (_side(b, middle), b.middle[1] * (1 if b.middle[0] < middle else -1)))
    else:
        ordered = sorted(burners, key=lambda b: (-round(b.middle[1], 3), b.middle[0]))
    for burner, knob in zip(ordered, burner_knobs, strict=True):
        names |= _named(knob, f"knob_{burner.loc}")
    return names


def _side(burner: Burner, middle: float) -> int:
    """Return -1, 0 or 1 for a burner left of the middle, in it, or right of it."""
    offset = burner.middle[0] - middle
    return 0 if abs(offset) < burner.radius / 2 else 1 if offset > 0 else -1


def _toaster(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name the lever of each pair of slots, with the knob and the keys nearest to it: the lowest key cancels."""
    names: dict[str, RuntimeName] = {}
    levers = _sorted_in_line(_on_body(places, PartKind.LEVER))
    for word, lever in zip({1: ("",), 2: ("side_l_", "side_r_")}.get(len(levers), ()), levers, strict=False):
        names |= _named(lever, f"{word}lever")
        knobs, keys = (_nearest(lever, levers, _on_body(places, k)) for k in (PartKind.KNOB, PartKind.BUTTON))
        names |= _named(knobs[0], f"{word}knob_doneness") if len(knobs) == 1 else {}
        cancel = f"{word}button_cancel"
        names |= _named(min(keys, key=lambda p: _coordinate(p, 2)), cancel, shape=cancel) if keys else {}
    return names


def _nearest(anchor: PlacedPart, anchors: Sequence[PlacedPart], parts: Sequence[PlacedPart]) -> list[PlacedPart]:
    """Return the parts that are nearer to one part than to the others like it; ties go to the first."""

    def distance(place: PlacedPart, other: PlacedPart) -> float:
        return round(float(np.linalg.norm(place.middle - other.middle)), 4)

    return [part for part in parts if min(anchors, key=lambda p: distance(p, part)) is anchor]


def _coffee_machine(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name the largest key of a coffee machine its start button."""
    keys = sorted(
        _on_body(places, PartKind.BUTTON),
        key=lambda p: (-round(float(np.prod(np.sort(p.size)[1:])), 6), _coordinate(p, 0)),
    )
    return _named(keys[0], "start_button", shape="start_button") if keys else {}


def _kettle(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name the lid, the lowest key as the switch, and the highest as the key that opens the lid."""
    names: dict[str, RuntimeName] = {}
    lids = _on_body(places, PartKind.LID)
    if len(lids) == 1:
        names |= _named(lids[0], "lid")
    keys = sorted(
        (p for p in places if p.part.kind in (PartKind.LEVER, PartKind.BUTTON)), key=lambda p: _coordinate(p, 2)
    )
    if keys:
        names |= _named(keys[0], "switch")
    if len(keys) > 1:
        names |= _named(keys[-1], "button_lid")
    return names


def _faucet(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name the spout, the flow handle, and the temperature handle, which is the left one of two."""
    names: dict[str, RuntimeName] = {}
    spouts = _on_body(places, PartKind.SPOUT)
    if len(spouts) == 1:
        names |= _named(spouts[0], "spout")
    controls = [*_on_body(places, PartKind.LEVER), *_on_body(places, PartKind.KNOB)]
    handles = sorted((p for p in controls if p.part.joint.kind is JointKind.HINGE), key=lambda p: -_coordinate(p, 0))
    for word, handle in zip(("handle", "handle_temp"), handles, strict=False):
        names |= _named(handle, word)
    return names


def _fridge(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name doors and drawers by their layout: side by side, or one above the other."""
    doors = sorted(_on_body(places, PartKind.DOOR), key=lambda p: _coordinate(p, 0))
    drawers = sorted(_on_body(places, PartKind.DRAWER), key=lambda p: -_coordinate(p, 2))
    parts: list[tuple[PlacedPart, str]] = []
    if len(doors) == 1:
        parts = [(doors[0], "fridge_door")]
    elif len(doors) == 2:
        beside = abs(doors[0].middle[0] - doors[1].middle[0]) > abs(doors[0].middle[2] - doors[1].middle[2])
        if beside and drawers:
            parts = [(doors[0], "fridge_left_door"), (doors[1], "fridge_right_door")]
        elif beside:
            parts = [(doors[0], "freezer_door"), (doors[1], "fridge_door")]
        else:
            small, large = sorted(doors, key=lambda p: float(p.size[2]))
            parts = [(small, "freezer_door"), (large, "fridge_door")]
    elif len(doors) == 3:
        lower = min(doors, key=lambda p: _coordinate(p, 2))
        left, right = [p for p in doors if p is not lower]
        parts = [(left, "fridge_left_door"), (right, "fridge_right_door"), (lower, "freezer_door")]
    names: dict[str, RuntimeName] = {}
    for place, word in parts:
        names |= _named(place, word)
    if parts and not any(w.startswith("freezer") for _, w in parts) and drawers:
        names |= _named(drawers[-1], "freezer_door")
        drawers = drawers[:-1]
    for i, drawer in enumerate(drawers if parts else []):
        names |= _named(drawer, f"fridge_drawer{i}")
    return names


def _cabinet(places: Sequence[PlacedPart]) -> NamesByPart:
    """Name side-hinged doors, from the left and from above, and drawers."""
    doors = [p for p in _on_body(places, PartKind.DOOR) if p.part.joint.edge in (HingeEdge.LEFT, HingeEdge.RIGHT)]
    doors.sort(key=lambda p: (-round(float(p.middle[2]), 2), _coordinate(p, 0)))
    drawers = sorted(
        _on_body(places, PartKind.DRAWER), key=lambda p: (-round(float(p.middle[2]), 3), _coordinate(p, 0))
    )
    pairs = len({p.part.joint.edge for p in doors}) == 2
    names: dict[str, RuntimeName] = {}
    count: dict[str, int] = {}
    for p in doors:
        word = f"{p.part.joint.edge.value}door" if pairs and p.part.joint.edge else "door"
        alike = sum(d.part.joint.edge is p.part.joint.edge for d in doors)
        prefix = f"unit{count.get(word, 0)}_" if alike > 1 else ""
        count[word] = count.get(word, 0) + 1
        names |= _named(p, f"{prefix}{word}", f"{prefix}{word}hinge")
    for i, p in enumerate(drawers):
        word = "drawer" if len(drawers) == 1 else f"drawer{i}"
        names |= _named(p, word, "slidejoint" if len(drawers) == 1 else f"{word}_slidejoint")
    return names


def _sorted_in_line(places: Sequence[PlacedPart]) -> list[PlacedPart]:
    """Sort parts in a row from the left, in a column from above, on a top from the far end."""
    if len(places) < 2:
        return list(places)
    axis = int(np.argmax(np.ptp([p.middle for p in places], axis=0)))
    return sorted(places, key=lambda p: _coordinate(p, axis) * (1 if axis == 0 else -1))


def _on_body(places: Sequence[PlacedPart], kind: PartKind) -> list[PlacedPart]:
    return [p for p in places if p.part.kind is kind and not p.part.parent]


def _coordinate(place: PlacedPart, axis: int) -> float:
    """Return where a part is along an axis, rounded to 0.1 mm so that the order does not depend on the last digit."""
    return round(float(place.middle[axis]), 4)


def rename_for_runtime(asset: Asset, articulation: Articulation, category: str) -> tuple[Asset, dict[str, str]]:
    """Rename an asset for its category and annotate it; return it with part name -> joint name.

    Parts that the category has no names for keep their own, as do all parts of an object without a category. The
    contract is the intended one: the checks decide whether it is met.
    """
    boxes = {p.name: link_bounds(asset, p.name) for p in articulation.parts}
    places = [
        PlacedPart(p, (boxes[p.name][0] + boxes[p.name][1]) / 2, boxes[p.name][1] - boxes[p.name][0])
        for p in articulation.parts
    ]
    burners = find_burners(asset) if category in ("hob", "range") else ()
    names = runtime_names(places, category, burners)
    new_names = {p.name: names.get(p.name, RuntimeName(p.name, f"{p.name}_joint")) for p in articulation.parts}
    opens_positive = {p.name for p in articulation.parts if p.name in names and p.kind in _PLAIN_AXES}
    joints = {part: name.joint for part, name in new_names.items()}
    links = {part: name.link for part, name in new_names.items()}
    joint_names = {f"{part}_joint": joint for part, joint in joints.items()}
    asset = asset.replace(
        links=tuple(_link(k, new_names) for k in asset.links),
        joints=tuple(
            _joint(j, new_names, joint_names, j.child in opens_positive, j.child in names) for j in asset.joints
        ),
        states=tuple(
            s.replace(name=s.name.replace(s.joint, joint_names[s.joint]), joint=joint_names[s.joint])
            for s in asset.states
        ),
        exclusions=tuple(
            e.replace(first=links.get(e.first, e.first), second=links.get(e.second, e.second)) for e in asset.exclusions
        ),
        regions=(main_region(asset), *(r.replace(link=links.get(r.link, r.link)) for r in asset.regions)),
    )
    return (annotate_for_runtime(asset, category, burners) if category else asset), joints


def main_region(asset: Asset) -> Region:
    """Return the box by which an asset is placed: all of it but its handles and controls."""
    clouds = []
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        clouds += [pose.apply(v.mesh.vertices) for v in link.visuals if v.label not in _OUTSIDE]
    points = np.concatenate(clouds or [asset.bounds])
    lower, upper = points.min(axis=0), points.max(axis=0)
    return Region(
        name="main",
        pose=Pose(position=round7_vec3((lower + upper) / 2)),
        size=round7_vec3(np.maximum(upper - lower, 1e-3)),
    )


def _link(link: Link, new_names: Mapping[str, RuntimeName]) -> Link:
    """Return a link with its colliders and visuals renamed."""
    name = new_names[link.name].link if link.name in new_names else link.name
    parent = new_names[link.parent].link if link.parent is not None and link.parent in new_names else link.parent
    first = new_names[link.name].shape if link.name in new_names else ""

    def renamed_word(word: str) -> str:
        return name + word[len(link.name) :] if word.startswith(link.name) else word

    colliders = tuple(
        c.replace(name=first if first and not i else renamed_word(c.name)) for i, c in enumerate(link.colliders)
    )
    visuals = tuple(v.replace(name=renamed_word(v.name)) for v in link.visuals)
    return link.replace(name=name, parent=parent, colliders=colliders, visuals=visuals)


def _joint(
    joint: Joint,
    new_names: Mapping[str, RuntimeName],
    joint_names: Mapping[str, str],
    opens_positive: bool,
    known: bool,
) -> Joint:
    """Return a joint renamed and with its axis snapped to x, y or z; that of a front points along +x, +y or +z.

    The range of a knob that sets something is limited: it does not turn endlessly.
    """
    name = new_names[joint.child]
    grip = None
    if joint.grip is not None:
        grip = name.shape or name.link + joint.grip[len(joint.child) :]
    renamed = joint.replace(
        name=name.joint,
        child=name.link,
        grip=grip,
        axis=_straight(joint.axis),
        behind=None if joint.behind is None else joint_names[joint.behind],
    )
    if known and name.joint.startswith("knob_") and renamed.range[1] > KNOB_SETTING_RANGE_RAD:
        return renamed.replace(range=(renamed.range[0], KNOB_SETTING_RANGE_RAD))
    if not opens_positive or max(renamed.axis, key=abs) > 0:
        return renamed
    x, y, z = (-c if c else 0.0 for c in renamed.axis)
    drive = None if renamed.drive is None else renamed.drive.replace(target=-renamed.drive.target)
    lower, upper = renamed.range
    return renamed.replace(axis=(x, y, z), range=(-upper, -lower if lower else 0.0), drive=drive)


def _straight(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    """Snap an axis to x, y or z where it is nearly that."""
    k = max(range(3), key=lambda i: abs(axis[i]))
    if abs(axis[k]) < AXIS_SNAP_COS:
        return axis
    x, y, z = (float(np.sign(axis[k])) if i == k else 0.0 for i in range(3))
    return (x, y, z)
