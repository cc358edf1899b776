"""A subject as it is shown: to the page a GLB, facts and state machines, to MuJoCo a compiled model."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, Field, ValidationError

from casa_assets.addons.robots.certify import read_certificate
from casa_assets.checks.design.floor_map import BASE_RADIUS_M
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.core.numeric import decimals
from casa_assets.errors import CasaError
from casa_assets.families.asset_store import AssetStore
from casa_assets.families.build import family_of, params_of
from casa_assets.formats.gltf import asset_glb, scene_glb
from casa_assets.formats.mjcf import document
from casa_assets.formats.mjcf.kitchen import FILE, write
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run.load_scene import model_of
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_choice, build_scene, draw_surfaces, resolve
from casa_assets.layouts.run.scene_folders import is_current
from casa_assets.library.entry_files import checked_model, read_asset
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.behavior import Behavior, BehaviorState, Stimulus, start_behavior, step_behavior
from casa_assets.model.asset.parts import Region, Site
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.files import SCENE_JSON, SHARED
from casa_assets.model.kitchen.robot import Following
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.record import Record
from casa_assets.registry.kitchens import load_plan, load_style, style_names
from casa_assets.show.view.subject import AssetFolder, Kitchen, Loaded, Member, ModelFile, Subject
from casa_assets.textures.run.recipes import available_finishes

DIGITS = 5  # of metres: a hundredth of a millimetre
# A page that was asleep comes back after minutes; a rule of 25 s is then over, and no longer step says more.
MAX_STEP_S = 60.0
REPORT = "report.html"
# Called with what is being done, how much of it is done, and of how many; 0 where that is not known.
ShowProgress = Callable[[str, int, int], None]


class Step(Record):
    """State of one fixture, as a page sends it for a step of its state machine.

    Attributes:
        placement: name of the fixture; empty for an asset by itself.
        values, before, held_s: as in the last answer; empty at the start.
        joints: name without that of the placement -> position, rad or m; those not listed are at zero.
        touched: names of colliders that are being pressed. dt_s: seconds since the last step.
    """

    model_config = ConfigDict(extra="forbid")

    placement: str = ""
    values: dict[str, str] = Field(default_factory=dict)
    before: tuple[tuple[bool, ...], ...] | None = None
    held_s: tuple[float, ...] = ()
    joints: dict[str, float] = Field(default_factory=dict)
    touched: tuple[str, ...] = ()
    dt_s: float = 0.0


def parse_step(data: bytes) -> Step:
    """Parse a step from JSON. Raises CasaError if it is not a valid step."""
    try:
        return Step.model_validate_json(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise CasaError(f"this is no step of a state machine: {where}: {first['msg']}") from error


def step_machine(behavior: Behavior, step: Step) -> dict[str, Any]:
    """The next state of a machine, and the effects that act in it, as JSON has them.

    `waits`: whether a rule is counting seconds, so that time alone changes something. Raises CasaError for a state that
    this machine cannot be in.
    """
    state = start_behavior(behavior)
    if step.values:
        known = {variable.name: variable.values for variable in behavior.variables}
        if set(step.values) != set(known) or any(value not in known[name] for name, value in step.values.items()):
            raise CasaError(f"{step.values} is no state of this machine; it has {known}")
        state = BehaviorState(behavior, step.values, step.before, step.held_s)
        if len(step.held_s) != len(behavior.rules) or (
            step.before is not None
            and [len(held) for held in step.before] != [len(rule.when) for rule in behavior.rules]
        ):
            raise CasaError(f"{step.placement or 'the asset'}: the state has not the rules of this machine")
    joints = {name: step.joints.get(name, 0.0) for name in behavior.joints}
    seconds = min(max(step.dt_s, 0.0), MAX_STEP_S)
    after = step_behavior(state, Stimulus(joints, frozenset(step.touched)), seconds)
    waits = any(rule.after_s and held for rule, held in zip(behavior.rules, after.held_s, strict=True))
    return {
        "values": dict(after.values),
        "before": after.before,
        "held_s": after.held_s,
        "effects": [
            {"kind": one.kind.value, "target": one.target, "color": list(one.color), "strength": one.strength}
            for one in after.effects
        ],
        "waits": waits,
    }


def describe_machine(asset: Asset, placement: str = "") -> dict[str, Any] | None:
    """The data with which a page shows an asset's state machine, or None if it has none.

    `contacts`: colliders that are pressed, with the joint of the key, null if it does not move. `targets`: name of a
    site, visual or region that effects act on -> its link, and points and faces or place and size.
    """
    behavior = asset.behavior
    if behavior is None:
        return None
    moved_by = {c.name: asset.joint_of(link.name) for link in asset.links for c in link.colliders}
    contacts = [(name, moved_by[name]) for name in dict.fromkeys(behavior.contacts)]
    return {
        "placement": placement,
        "variables": {variable.name: list(variable.values) for variable in behavior.variables},
        "joints": list(dict.fromkeys(behavior.joints)),
        "contacts": [{"name": name, "joint": joint.name if joint else None} for name, joint in contacts],
        "targets": {name: _target(asset, name) for name in dict.fromkeys(behavior.targets)},
    }


def _target(asset: Asset, name: str) -> dict[str, Any]:
    for link in asset.links:
        for visual in link.visuals:
            if visual.name == name:
                points = [_rounded(point) for point in visual.mesh.vertices.tolist()]
                return {"is": "visual", "link": link.name, "points": points, "faces": visual.mesh.faces.tolist()}
    places: tuple[Site | Region, ...] = (*asset.sites, *asset.regions)
    place = next(place for place in places if place.name == name)
    size = [2 * place.radius] * 3 if isinstance(place, Site) and place.size is None else list(place.size or ())
    kind = "site" if isinstance(place, Site) else "region"
    position, quaternion = _rounded(place.pose.position), _rounded(place.pose.quaternion)  # (w, x, y, z)
    pose = {"position": position, "quaternion": quaternion}
    return {"is": kind, "link": place.link, "shape": place.kind, "size": size, **pose}


def _rounded(numbers: Any) -> list[float]:
    return [decimals(float(number), DIGITS) for number in numbers]


@dataclass(frozen=True)
class Model:
    """A model with colliders and regions in separate layers, and its data, as the server sends them to the page.

    `behaviors`: name of a placement (empty for an asset by itself) -> its state machine. `folder`: if it is on disk.
    """

    id: str
    glb: bytes
    facts: Mapping[str, Any]
    behaviors: Mapping[str, Behavior]
    folder: Path | None


def make(subject: Subject, cache: Path, show_progress: ShowProgress) -> Model:
    """Build or read the model to be shown, with a store in `cache`. Raises CasaError, also if a record is missing."""
    if isinstance(subject, Kitchen):
        return _kitchen(subject, cache, show_progress)
    show_progress("reading" if isinstance(subject, AssetFolder) else "building", 0, 0)
    asset = asset_of(subject, cache)
    folder = subject.folder if isinstance(subject, AssetFolder) else None
    show_progress("writing the model", 0, 0)
    glb = asset_glb(asset, with_layers=True)
    facts = {
        "id": asset.id,
        "kind": "asset",
        "title": subject.id,
        "sentence": f"{asset.labels.category.replace('_', ' ')}, {asset.mass:.3g} kg, {len(asset.joints)} joints",
        "machines": [m for m in (describe_machine(asset),) if m],
        "labels": [{"node": joint.child, "text": joint.child} for joint in asset.joints],
        "report": (folder / REPORT).is_file() if folder else False,
    }
    return Model(subject.id, glb, facts, {"": asset.behavior} if asset.behavior else {}, folder)


def asset_of(subject: Subject, cache: Path) -> Asset:
    """Return the record of an asset. Raises CasaError if it has no record: a scene, or an MJCF from elsewhere."""
    if isinstance(subject, AssetFolder):
        return read_asset(subject.folder)
    if isinstance(subject, Loaded):
        return subject.asset
    if isinstance(subject, Member):
        request = subject.request
        store = AssetStore(cache)
        made = store.built(family_of(request), params_of(request))
        store.tidy()
        return made
    why = subject.why if isinstance(subject, ModelFile) else "it is a scene"
    raise CasaError(
        f"{subject.id}: the page is made from a record of this program, and {why}. Where there is a screen, MuJoCo's "
        "viewer shows the file: leave --web out"
    )


def scene_of(subject: Kitchen, cache: Path, show_progress: ShowProgress) -> tuple[KitchenRequest, Scene]:
    """The kitchen and the scene of a recipe, as `scenes build` makes them, with progress part by part."""
    show_progress("reading the plan", 0, 0)
    kitchen = resolve(subject.recipe)
    parts = (*(item.choice for item in kitchen.items), *kitchen.style.props)
    choices = {choice.model_dump_json(): (choice.preset, choice) for choice in parts}
    store = AssetStore(cache)
    for number, (name, choice) in enumerate(choices.values()):
        show_progress("building its parts", number, len(choices))
        build_choice(name, choice, store)
    store.tidy()
    show_progress("putting it together", 0, 0)
    return build_scene(subject.recipe, cache)


def _kitchen(subject: Kitchen, cache: Path, show_progress: ShowProgress) -> Model:
    kitchen, scene = scene_of(subject, cache, show_progress)
    show_progress("writing the model", 0, 0)
    glb = scene_glb(scene, with_layers=True)
    show_progress("looking where a robot stands", 0, 0)
    places = DesignSubject(facts_of(kitchen, scene)).parking.shut.items()
    assets = scene.asset_of
    folder = subject.folder if (subject.folder / SCENE_JSON).is_file() else None
    joints = sum(len(asset.joints) for asset in assets.values())
    found = [describe_machine(asset, name) for name, asset in assets.items()]
    facts = {
        "id": scene.id,
        "kind": "scene",
        "title": scene.id,
        "sentence": f"{load_plan(subject.recipe.plan)[0].title}; {len(scene.placements)} placements, {joints} joints",
        "machines": [m for m in found if m],
        "labels": [{"node": name, "text": name} for name, asset in assets.items() if asset.joints or asset.behavior],
        "report": (folder / REPORT).is_file() if folder else False,
        "note": _note(subject, folder),
        "cameras": [camera.name for camera in scene.cameras],
        "base_radius": BASE_RADIUS_M,
        "parking": {
            fixture: place and {"x": place.position[0], "y": place.position[1], "yaw": place.yaw}
            for fixture, place in places
        },
        "robots": _robots(folder) if folder else [],
        "choice": choice_of(subject.recipe),
    }
    behaviors = {name: asset.behavior for name, asset in assets.items() if asset.behavior}
    return Model(scene.id, glb, facts, behaviors, folder)


def _note(subject: Kitchen, folder: Path | None) -> str:
    """A sentence on how what is shown differs from what is on the disk; empty where it does not."""
    if folder is None:
        return f"not on the disk yet; to write it: {build_command(subject.recipe)}"
    if not is_current(subject.recipe, subject.place):
        return "the files on the disk were made by another version; shown is what this version makes"
    return ""


def build_command(recipe: SceneRecipe) -> str:
    """The command that writes the scene of a recipe to the disk."""
    has_options = bool(recipe.surfaces or recipe.models or recipe.closed or recipe.mixed)
    if not has_options and recipe.seed is None:
        return f"casa-assets scenes build {recipe.scene_id}"
    words = [f"casa-assets scenes new {recipe.plan} --style {recipe.style}"]
    if recipe.seed is not None:
        words.append(f"--seed {recipe.seed}")
    if recipe.surfaces and recipe.surfaces == draw_surfaces(recipe.seed or 0):
        words.append("--textures random")
    elif recipe.surfaces:
        words.append("--textures " + ",".join(f"{surface.value}={name}" for surface, name in recipe.surfaces))
    words += [f"--model {role}={name}" for role, name in recipe.models]
    words += ["--mixed"] * recipe.mixed + ["--closed"] * recipe.closed
    if recipe.objects:
        words.append(f"--objects {recipe.objects} --objects-seed {recipe.objects_seed}")
    return " ".join(words)


def _robots(folder: Path) -> list[dict[str, Any]]:
    """Findings of `casa-assets scenes robots`: for each robot, `placement/joint` -> `opened`, `reached` or why not."""
    certificate = read_certificate(folder)
    if certificate is None:
        return []
    rows = []
    for robot in certificate.robots:
        joints = {}
        for joint in robot.joints:
            found = "opened" if joint.followed is not Following.NO else "reached"
            missed = joint.missed.value if joint.missed else "not reached"
            joints["/".join(joint.joint.rsplit("__", 1))] = found if joint.reached else missed
        rows.append({"robot": robot.robot, "joints": joints})
    return rows


def choice_of(recipe: SceneRecipe) -> dict[str, Any]:
    """Plan, style and surfaces of a kitchen, and what they can be swapped for."""
    textures = available_finishes().surfaces
    return {
        "plan": recipe.plan,
        "style": recipe.style,
        "seed": recipe.seed,
        "surfaces": {surface.value: name for surface, name in recipe.surfaces},
        "styles": {name: load_style(name)[0].description for name in style_names()},
        "textures": {surface.value: list(textures[surface]) for surface in Surface},
    }


def to_json(facts: Mapping[str, Any]) -> bytes:
    """Facts as the page reads them."""
    return json.dumps(facts, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def with_style(recipe: SceneRecipe, style: str) -> SceneRecipe:
    """The kitchen in another style, with that style's own finishes. Raises UnknownId."""
    load_style(style)
    return replace(recipe, style=style, surfaces=())


def mujoco_model(subject: Subject, cache: Path, show_progress: ShowProgress) -> Any:
    """A compiled MuJoCo model of the subject, an asset on a floor. Raises CasaError."""
    source = _source(subject, cache, show_progress)
    show_progress("loading", 0, 0)
    try:
        return model_of(source)
    except ValueError as error:
        raise CasaError(f"{subject.id}: MuJoCo cannot read it: {error}".replace("\n", " ")) from error


def _source(subject: Subject, cache: Path, show_progress: ShowProgress) -> Path | Files:
    if isinstance(subject, ModelFile):
        return subject.path
    if isinstance(subject, AssetFolder):
        on_floor = subject.folder / FILE
        return checked_model(on_floor if on_floor.is_file() else subject.folder / "model.xml")
    if isinstance(subject, Kitchen):
        file = subject.folder / FILE
        if file.is_file() and (subject.is_named_by_path or is_current(subject.recipe, subject.place)):
            return file
        return write(scene_of(subject, cache, show_progress)[1], shared=SHARED)
    return document.write(asset_of(subject, cache))
