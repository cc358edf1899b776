"""Add what runtimes read in an appliance: regions, sites, poses, and the state machine of its parts."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from casa_assets.articulate.runtime.places import (
    Bounds,
    Burner,
    burner_faces,
    closing_link,
    find_cup_niche,
    find_toaster_slots,
    floor_collider,
    is_occupied,
    link_bounds,
    link_label,
    niche_floor,
    region_below_racks,
    region_in_drawer,
    region_over_rack,
    region_within_colliders,
    split_by_shelves,
)
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Asset, Collider, JointKind, JointValue, Keyframe, Region, Site
from casa_assets.model.asset.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable
from casa_assets.model.asset.parts import Joint, Mesh, Visual
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec4

MAIN_REGION = "main"
FLAME_HIDDEN_RGBA: Vec4 = (0.06, 0.2, 0.75, 0.0)
COFFEE_HIDDEN_RGBA: Vec4 = (0.05, 0.025, 0.012, 0.0)
LAMP_OFF_RGBA: Vec4 = (1.0, 0.88, 0.65, 0.0)
FLAME_M, STREAM_M = 0.02, 0.012
# Contract of a category, by the fixture class that reads it.
CONTRACTS = {
    "microwave": "microwave",
    "wall_oven": "oven",
    "toaster_oven": "toaster_oven",
    "range": "stove",
    "hob": "stovetop",
    "dishwasher": "dishwasher",
    "coffee_machine": "coffee_machine",
    "toaster": "toaster",
    "kettle": "electric_kettle",
    "sink": "sink",
    "island_base": "island_base",
    "hood": "hood",
}
CABINET_WORDS = ("cabinet", "drawer_stack", "sink_base", "island_base")
REFRIGERATOR = "refrigerator"
# Share of its range up to which a door counts as shut. Ref: RoboCasa v1.0, is_closed.
DOOR_SHUT_SHARE = 0.005
# Where a knob lights its burner, and where it burns high, rad. Ref: class Stove, STOVE_LOW_MIN, STOVE_HIGH_MIN.
BURNER_LOW_RAD, BURNER_HIGH_RAD = 0.35, math.radians(80)
# Shares of its range at which a toaster's lever is down, and up again. Ref: class Toaster.
LEVER_DOWN_SHARE, LEVER_UP_SHARE = 0.9, 0.7
# Shares of the range: a kettle's switch is on, its lid is shut, or open. Ref: class ElectricKettle.
SWITCH_ON_SHARE, LID_SHUT_SHARE, LID_OPEN_SHARE = 0.95, 0.01, 0.9
# Angle at which a faucet begins to run. Ref: class Sink.
FAUCET_ON_RAD = 0.4
# How long a coffee machine pours. A choice.
POURS_S = 25.0
# Joints give a little beyond their stops, rad or m.
STOP_SLACK = 0.01
FLAME: Vec4 = (0.06, 0.2, 0.75, 0.6)
BREW: Vec4 = (0.05, 0.025, 0.012, 1.0)
WATER: Vec4 = (0.45, 0.62, 0.75, 0.6)
WARM: Vec4 = (1.0, 0.88, 0.65, 1.0)
WHITE: Vec4 = (1.0, 1.0, 1.0, 1.0)
_Parts = tuple[list[Variable], list[Rule], list[Effect]]  # of a state machine
NOTHING: _Parts = ([], [], [])


def annotate_for_runtime(asset: Asset, category: str, burners: Sequence[Burner] = ()) -> Asset:
    """Return an asset with the regions, sites, poses, states and contract of its category.

    Args:
        asset: its joints under the names of its kind, `main` among its regions. burners: on its top.
    """
    asset = asset.replace(regions=tuple(_regions(asset, category)))
    if category in ("hob", "range"):
        asset = _with_burners(asset, burners)
    annotators = {
        "coffee_machine": _with_cup,
        "toaster": _with_slots,
        "microwave": _with_tray,
        REFRIGERATOR: _with_lamp,
    }
    if category in annotators:
        asset = annotators[category](asset)
    asset = asset.replace(behavior=behavior_for(asset, category), contract=contract_for(asset, category))
    return asset.replace(keyframes=tuple(_poses(asset)))


def contract_for(asset: Asset, category: str) -> str | None:
    """Return the id of the contract that a runtime expects of such an asset; None if no fixture class reads it."""
    names = [j.name for j in asset.joints]
    if category == REFRIGERATOR:
        return _fridge_contract(asset, names)
    if category in CONTRACTS or not is_cabinet(category):
        return CONTRACTS.get(category)
    if any(n.endswith(("leftdoorhinge", "rightdoorhinge")) for n in names):
        return "hinge_cabinet"
    if any(n.endswith("doorhinge") for n in names):
        return "single_cabinet"
    return "drawer" if any(n.endswith("slidejoint") for n in names) else None


def _fridge_contract(asset: Asset, names: Sequence[str]) -> str | None:
    """Return the contract of a refrigerator by the layout of its doors."""
    if "fridge_left_door_joint" in names:
        return "fridge_french_door"
    if "fridge_door_joint" not in names:
        return None
    if "freezer_door_joint" not in names:
        return "fridge_bottom_freezer"
    fridge, freezer = (link_bounds(asset, f"{w}_door") for w in ("fridge", "freezer"))
    if fridge[0][0] >= freezer[1][0] - 0.01:
        return "fridge_side_by_side"
    return "fridge_top_freezer" if freezer[0][2] > fridge[0][2] else "fridge_bottom_freezer"


def _regions(asset: Asset, category: str) -> Iterator[Region]:
    """Yield regions under the names of the category, lower ones first; then those of drawers and racks without any."""
    inner = [r for r in asset.regions if r.name != MAIN_REGION]
    inner.sort(key=lambda r: (round(_middle(asset, r)[2], 3), round(_middle(asset, r)[0], 3)))
    count: Counter[str] = Counter()
    yield from (r for r in asset.regions if r.name == MAIN_REGION)
    racks = [k.name for k in asset.links if re.fullmatch(r"rack[0-9]|tray", k.name)]
    for region in inner:
        if region.link in racks:
            continue
        shelved = category == REFRIGERATOR or is_cabinet(category)
        below = None if shelved else region_below_racks(asset, region)
        for part in split_by_shelves(asset, region) if shelved else [below] if below is not None else []:
            if is_occupied(asset, part):
                continue
            if not shelved:
                part = region_within_colliders(asset, part)
            word = _word(asset, part, category)
            number = count[word]
            count[word] += 1
            numbered = word.endswith(("shelf", "level", "drawer"))
            name = f"{word}{number}" if numbered else word if not number else f"{word}_{number}"
            yield part.replace(name=name)
    filled = {r.link for r in inner}
    for drawer in (k.name for k in asset.links if k.name not in filled and link_label(asset, k.name) == "drawer"):
        inner_region = region_in_drawer(asset, drawer)
        if inner_region is not None:
            word = _word(asset, inner_region, category)
            yield inner_region.replace(name=f"{word}{count[word]}" if word.endswith("drawer") else word)
            count[word] += 1
    for rack in racks:
        inner_region = region_over_rack(asset, rack, [r for r in inner if r.link == "object"])
        if inner_region is not None:
            yield inner_region.replace(name=rack)


def _word(asset: Asset, region: Region, category: str) -> str:
    """Return the name of a region without its number."""
    if region.link != "object":
        if category == REFRIGERATOR:
            return ("freezer" if region.link.startswith("freezer") else "fridge") + "_drawer"
        return "int" if region.link == "drawer" and is_cabinet(category) else f"{region.link}_int"
    if category == REFRIGERATOR:
        door = closing_link(asset, region)
        return ("freezer" if door.startswith("freezer") else "fridge") + "_shelf"
    return "level" if is_cabinet(category) else "int"


def is_cabinet(category: str) -> bool:
    """Return whether a category is one of cabinets."""
    return any(word in category for word in CABINET_WORDS)


def _middle(asset: Asset, region: Region) -> Floats:
    """Return the (3,) middle of a region, asset frame."""
    return np.asarray(asset.asset_from_link(region.link).apply(np.array([region.pose.position]))[0])


def _with_burners(asset: Asset, burners: Sequence[Burner]) -> Asset:
    """Add flames and places over the burners that have a knob, and give their visuals the names of burners."""
    knobs = {j.name for j in asset.joints}
    controlled = [b for b in burners if f"knob_{b.loc}_joint" in knobs]
    sites: list[Site] = []
    for b in controlled:
        x, y, z = b.middle
        diameter = 1.3 * b.radius
        flame = Pose(position=(x, y, round(z + FLAME_M / 2, 4)))
        sites.append(
            Site(
                name=f"burner_on_{b.loc}",
                pose=flame,
                kind="cylinder",
                size=(diameter, diameter, FLAME_M),
                color=FLAME_HIDDEN_RGBA,
            )
        )
        sites.append(Site(name=f"burner_{b.loc}_place_site", pose=Pose(position=b.middle), radius=0.01))
    visuals: list[Visual] = []
    for visual in asset.root.visuals:
        remaining = np.ones(len(visual.mesh.faces), dtype=bool)
        for b in controlled:
            burner_rows = burner_faces(visual.mesh, b) & remaining
            if burner_rows.any() and not burner_rows.all():
                remaining &= ~burner_rows
                name = f"burner_{b.loc}_{visual.name.removeprefix('object_')}"
                visuals.append(visual.replace(name=name, mesh=_rows(visual.mesh, burner_rows), label="burner"))
        kept = visual if remaining.all() else visual.replace(mesh=_rows(visual.mesh, remaining))
        visuals += [kept] if remaining.any() else []
    root = asset.root.replace(visuals=tuple(visuals))
    return asset.replace(links=(root, *asset.links[1:]), sites=(*asset.sites, *sites))


def _rows(mesh: Mesh, own: npt.NDArray[np.bool_]) -> Mesh:
    faces = mesh.faces[own]
    used, local = np.unique(faces, return_inverse=True)
    return Mesh(
        vertices=mesh.vertices[used],
        faces=local.reshape(-1, 3),
        uv=None if mesh.uv is None else mesh.uv[used],
        normals=None if mesh.normals is None else mesh.normals[used],
    )


def _with_cup(asset: Asset) -> Asset:
    place = find_cup_niche(asset)
    if place is None:
        return asset
    lower, upper = place
    x, y, _ = (round(float(v), 4) for v in (lower + upper) / 2)
    z, tall = float(lower[2]), float(upper[2] - lower[2])
    stream = Pose(position=(x, y, round(z + 0.6 * tall, 4)))
    size = (STREAM_M, STREAM_M, round(0.8 * tall, 4))
    sites = (
        Site(name="receptacle_place_site", pose=Pose(position=(x, y, z)), radius=0.01),
        Site(name="coffee_liquid", pose=stream, kind="cylinder", size=size, color=COFFEE_HIDDEN_RGBA),
    )
    return asset.replace(sites=(*asset.sites, *sites))


def _with_slots(asset: Asset) -> Asset:
    """Add the slots of a toaster with their floors, where there are two or four."""
    found = find_toaster_slots(asset)
    words = {2: ("slotL", "slotR"), 4: tuple(f"side{a}_slot{b}" for a in "LR" for b in "LR")}.get(len(found), ())
    regions, floors = [], []
    for word, niche in zip(words, found, strict=False):
        regions.append(_region(word, niche))
        shape, pose = niche_floor(niche)
        substance = asset.root.colliders[0].substance
        floors.append(Collider(name=f"{word}_floor", shape=shape, pose=pose, substance=substance))
    root = asset.root.replace(colliders=(*asset.root.colliders, *floors))
    return asset.replace(links=(root, *asset.links[1:]), regions=(*asset.regions, *regions))


def _region(name: str, niche: Bounds) -> Region:
    lower, upper = niche
    x, y, z = (round(float(v), 4) for v in (lower + upper) / 2)
    a, b, c = (round(max(float(v), 1e-3), 4) for v in upper - lower)
    return Region(name=name, pose=Pose(position=(x, y, z)), size=(a, b, c))


def _with_tray(asset: Asset) -> Asset:
    """Name the floor of a microwave without turntable its tray."""
    cavity = next((r for r in asset.regions if r.name == "int"), None)
    shapes = {c.name for k in asset.links for c in k.colliders}
    regions = {r.name for r in asset.regions}
    if cavity is not None and "tray" not in regions:
        asset = asset.replace(regions=(*asset.regions, cavity.replace(name="tray")))
    under = floor_collider(asset, cavity) if cavity is not None and "tray" not in shapes else None
    if under is None:
        return asset
    colliders = tuple(c.replace(name="tray") if c.name == under else c for c in asset.root.colliders)
    return asset.replace(links=(asset.root.replace(colliders=colliders), *asset.links[1:]))


def _with_lamp(asset: Asset) -> Asset:
    shelves = [r for r in asset.regions if r.name.startswith("fridge_shelf")]
    if not shelves:
        return asset
    highest = max(shelves, key=lambda r: (round(_middle(asset, r)[2], 4), r.name))
    x, y, z = _middle(asset, highest)
    at = (round(float(x), 4), round(float(y), 4), round(float(z) + highest.size[2] / 2 - 0.012, 4))
    return asset.replace(
        sites=(*asset.sites, Site(name="lamp", pose=Pose(position=at), radius=0.01, color=LAMP_OFF_RGBA))
    )


def _poses(asset: Asset) -> Iterator[Keyframe]:
    """Yield the poses closed, open (every front) and on."""
    joints = asset.joints
    yield Keyframe(name="closed")
    fronts = [j for j in joints if j.behind is None and link_label(asset, j.child) in ("door", "drawer", "lid")]
    upper_racks = [j for j in joints if j.name == "rack1_joint" and asset.contract == "dishwasher"]
    open_joints = [*((j, 1.0) for j in fronts), *((j, 0.6) for j in upper_racks)]
    if open_joints:
        yield _pose("open", open_joints)
    on_joints = [(j, 0.5) for j in joints if re.fullmatch(r"knob_(rear|front|center|left|right).*_joint", j.name)]
    on_joints += [(j, 0.5) for j in joints if j.name == "handle_joint" and j.kind is JointKind.HINGE]
    on_joints += [(j, 1.0) for j in joints if j.name.endswith("lever_joint") or j.name == "switch_joint"]
    if on_joints:
        yield _pose("on", on_joints)


def _pose(name: str, joint_shares: Sequence[tuple[Joint, float]]) -> Keyframe:
    values = tuple(JointValue(joint=j.name, value=max(j.range, key=abs) * share) for j, share in joint_shares)
    return Keyframe(name=name, joints=values)


def behavior_for(asset: Asset, category: str) -> Behavior | None:
    """Return the state machine of an asset of a category, as far as its parts exist; None if it has no states.

    Args:
        asset: under the names of its kind, with its regions and sites.
    """
    makers = {
        "microwave": _microwave,
        "hob": _burners,
        "range": _burners,
        "refrigerator": _fridge,
        "toaster_oven": _toaster_oven,
        "toaster": _toaster,
        "coffee_machine": _coffee_machine,
        "kettle": _kettle,
        "sink": _faucet,
    }
    if category not in makers:
        return None
    variables, rules, effects = makers[category](asset, {j.name: j for j in asset.joints})
    return Behavior(variables=tuple(variables), rules=tuple(rules), effects=tuple(effects)) if variables else None


def _has_shape(asset: Asset, name: str) -> bool:
    return any(c.name == name for k in asset.links for c in k.colliders)


def _microwave(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """Start heats while the door is shut; the stop key or opening the door ends it."""
    if not (_has_shape(asset, "start_button") and _has_shape(asset, "stop_button")):
        return NOTHING
    start, stop = (Condition(contact=c, begins=True) for c in ("start_button", "stop_button"))
    rules = [Rule(variable="power", from_values=("on",), to="off", when=(stop,))]
    shut: tuple[Condition, ...] = ()
    if "microjoint" in joints:
        shut = (_is_shut(joints["microjoint"]),)
        rules.insert(0, Rule(variable="power", from_values=("on",), to="off", when=(shut[0].replace(negated=True),)))
    rules.append(Rule(variable="power", from_values=("off",), to="on", when=(start, *shut)))
    spins = [v.name for k in asset.links if k.name == "tray" for v in k.visuals]
    effects = [*_effects(asset, "power", "on", EffectKind.HEAT, ("int",))]
    effects += [Effect(variable="power", value="on", kind=EffectKind.SPIN, target=name) for name in spins]
    return [_switch("power")], rules, effects


def _burners(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """Each knob sets its burner to off, low or high."""
    variables, rules, effects = [], [], []
    for site in (s.name for s in asset.sites if s.name.startswith("burner_on_")):
        loc = site.removeprefix("burner_on_")
        name, joint = f"burner_{loc}", joints.get(f"knob_{loc}_joint")
        if joint is None:
            continue
        variables.append(Variable(name=name, values=("off", "low", "high"), initial="off"))
        spans = (
            ("off", (-0.1, BURNER_LOW_RAD)),
            ("low", (BURNER_LOW_RAD, BURNER_HIGH_RAD)),
            ("high", (BURNER_HIGH_RAD, joint.range[1] + 0.1)),
        )
        rules += [Rule(variable=name, to=v, when=(Condition(joint=joint.name, interval=s),)) for v, s in spans]
        for value, strength in (("low", 0.5), ("high", 1.0)):
            for kind in (EffectKind.SHOW, EffectKind.HEAT):
                visible = Effect(variable=name, value=value, kind=kind, target=site, strength=strength)
                effects.append(visible.replace(color=FLAME) if kind is EffectKind.SHOW else visible)
    return variables, rules, effects


def _fridge(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """The lamp is on while a door of the fridge is open."""
    closed = [_is_shut(j) for n, j in joints.items() if n.startswith("fridge") and "door" in n]
    if not closed:
        return NOTHING
    rules = [Rule(variable="light", to="off", when=tuple(closed))]
    rules += [Rule(variable="light", to="on", when=(s.replace(negated=True),)) for s in closed]
    effects = _effects(asset, "light", "on", EffectKind.SHOW, ("lamp",), WARM)
    return [_switch("light")], rules, effects


def _toaster_oven(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """A toaster oven heats while its timer, and its other knobs where they exist, are away from zero."""
    knobs = [joints[n] for n in ("knob_time_joint", "knob_temp_joint", "knob_function_joint") if n in joints]
    if not knobs or knobs[0].name != "knob_time_joint":
        return NOTHING
    turned = [Condition(joint=j.name, interval=(0.1 * j.range[1], j.range[1] + STOP_SLACK)) for j in knobs]
    rules = [Rule(variable="power", from_values=("on",), to="off", when=(t.replace(negated=True),)) for t in turned]
    rules.append(Rule(variable="power", from_values=("off",), to="on", when=tuple(turned)))
    heats = [r.name for r in asset.regions if r.name.startswith(("rack", "tray", "int"))]
    effects = _effects(asset, "power", "on", EffectKind.HEAT, heats)
    return [_switch("power")], rules, effects


def _toaster(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """A lever that goes down switches its slots on; its cancel key, or the lever going up, switches them off."""
    variables, rules, effects = [], [], []
    for stem, power in (("", "power"), ("side_l_", "power_l"), ("side_r_", "power_r")):
        lever = joints.get(f"{stem}lever_joint")
        if lever is None:
            continue
        variables.append(_switch(power))
        down = _range_between(lever, LEVER_DOWN_SHARE, 1.0, begins=True)
        rules.append(Rule(variable=power, from_values=("off",), to="on", when=(down,)))
        ends = [_range_between(lever, 0.0, LEVER_UP_SHARE)]
        if _has_shape(asset, f"{stem}button_cancel"):
            ends.insert(0, Condition(contact=f"{stem}button_cancel", begins=True))
        rules += [Rule(variable=power, from_values=("on",), to="off", when=(end,)) for end in ends]
        slots = [r.name for r in asset.regions if r.name.startswith(f"{stem}slot_")]
        effects += _effects(asset, power, "on", EffectKind.HEAT, slots)
    return variables, rules, effects


def _coffee_machine(asset: Asset, _: Mapping[str, Joint]) -> _Parts:
    """The start key starts a brew, which ends by itself."""
    if not _has_shape(asset, "start_button"):
        return NOTHING
    press, on = Condition(contact="start_button", begins=True), Condition(variable="power", equals="on")
    effects = _effects(asset, "power", "on", EffectKind.SHOW, ("coffee_liquid",), BREW)
    effects += _effects(asset, "power", "on", EffectKind.FLOW, ("coffee_liquid",), BREW)
    rules = [
        Rule(variable="power", from_values=("off",), to="on", when=(press,)),
        Rule(variable="power", from_values=("on",), to="off", when=(on,), after_s=POURS_S),
    ]
    return [_switch("power")], rules, effects


def _kettle(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """A kettle heats while its switch is down; its lid is open or closed at the ends of its range."""
    variables, rules = [], []
    if "switch_joint" in joints:
        down = _range_between(joints["switch_joint"], SWITCH_ON_SHARE, 1.0)
        variables.append(_switch("power"))
        rules.append(Rule(variable="power", from_values=("off",), to="on", when=(down,)))
        rules.append(Rule(variable="power", from_values=("on",), to="off", when=(down.replace(negated=True),)))
    if "lid_joint" in joints:
        lid = joints["lid_joint"]
        variables.append(Variable(name="lid", values=("closed", "open"), initial="closed"))
        wide, shut = _range_between(lid, LID_OPEN_SHARE, 1.0), _range_between(lid, 0.0, LID_SHUT_SHARE)
        rules.append(Rule(variable="lid", from_values=("closed",), to="open", when=(wide,)))
        rules.append(Rule(variable="lid", from_values=("open",), to="closed", when=(shut,)))
    effects = _effects(asset, "power", "on", EffectKind.HEAT, ("int",)) if "switch_joint" in joints else []
    return variables, rules, effects


def _faucet(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """The flow handle runs the water; the other handle, where there is one, sets hot or cold."""
    handle, other = joints.get("handle_joint"), joints.get("handle_temp_joint")
    if handle is None or handle.range[1] <= FAUCET_ON_RAD:
        return NOTHING
    end = handle.range[1]
    half = max(end / 2, FAUCET_ON_RAD)
    levels = {"off": (-STOP_SLACK, FAUCET_ON_RAD), "low": (FAUCET_ON_RAD, half), "high": (half, end + STOP_SLACK)}
    variables = [Variable(name="water", values=("off", "low", "high"), initial="off")]
    rules = [Rule(variable="water", to=v, when=(Condition(joint=handle.name, interval=i),)) for v, i in levels.items()]
    if other is not None:
        lower, upper = other.range
        middle = (lower + upper) / 2
        variables.append(Variable(name="temperature", values=("cold", "hot"), initial="cold"))
        for value, span in (("cold", (lower - STOP_SLACK, middle)), ("hot", (middle, upper + STOP_SLACK))):
            rules.append(Rule(variable="temperature", to=value, when=(Condition(joint=other.name, interval=span),)))
    effects = []
    for value, strength in (("low", 0.5), ("high", 1.0)):
        visible = _effects(asset, "water", value, EffectKind.SHOW, ("water",), WATER)
        visible += _effects(asset, "water", value, EffectKind.FLOW, ("water",), WATER)
        effects += [e.replace(strength=strength) for e in visible]
    return variables, rules, effects


def _switch(name: str) -> Variable:
    return Variable(name=name, values=("off", "on"), initial="off")


def _is_shut(joint: Joint) -> Condition:
    """Return the condition that a joint is no farther open than counts as shut."""
    return _range_between(joint, 0.0, DOOR_SHUT_SHARE)


def _range_between(joint: Joint, first: float, last: float, begins: bool = False) -> Condition:
    """Return the condition that a joint is between two shares of its range, from zero to its farther end."""
    end = max(joint.range, key=abs)
    ends = [first * end, last * end]
    if first <= 0.0:
        ends[0] = -math.copysign(STOP_SLACK, end)
    if last >= 1.0:
        ends[1] += math.copysign(STOP_SLACK, end)
    return Condition(joint=joint.name, interval=(min(ends), max(ends)), begins=begins)


def _effects(
    asset: Asset, variable: str, value: str, kind: EffectKind, targets: Sequence[str], color: Vec4 = WHITE
) -> list[Effect]:
    """Return the effects of a variable's value on those targets that exist."""
    there = {s.name for s in asset.sites} | {r.name for r in asset.regions}
    there |= {v.name for k in asset.links for v in k.visuals}
    return [Effect(variable=variable, value=value, kind=kind, target=t, color=color) for t in targets if t in there]
