"""Written formats of a scene against each other: MJCF and USD, URDF, and what validators say of the USD."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol, TypeVar

import mujoco
import numpy as np
from pxr import Sdf, Tf, Usd

from casa_assets.checks.check import Measurement, Problem, count, not_run
from casa_assets.checks.package.usd import Diagnostics, validator_findings
from casa_assets.checks.readers import mujoco_facts, urdf_facts, usd_facts
from casa_assets.checks.readers.facts import Cells, compare, four, frame, short_name, text, three
from casa_assets.checks.readers.mujoco_facts import Loaded, load_asset_file
from casa_assets.checks.readers.urdf_facts import LENGTH_TOLERANCE_M, TOLERANCE, UrdfAsset
from casa_assets.checks.readers.usd_facts import imported, missing_importer
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.simready import PROFILE, PROFILE_VERSION, Verdict, quiet, validate_simready
from casa_assets.checks.simready_python import NoVerdict, validator_python, validator_versions
from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.kitchen.scene import Scene

USD_FILE, NESTED_FILE, LIGHT_FILE = "scene.usda", "scene_nested.usda", "scene_light.xml"
MAX_LISTED = 20
Facts = TypeVar("Facts")
# Of ratios, unit vectors, radians, and masses relative to those of the body, which USD holds as float32.
SCENE_TOLERANCE = 1e-5
SCENE_LENGTH_TOLERANCE_M = 2e-6  # a float32 six metres from the origin is right to 2.4e-7
SAME = 1e-9  # numbers of two models that differ by less are the same: the two have a pose in one step and in several
LENGTHS = ("nbuffer", "nnames")  # sizes of a model that hang on how long its names are
# Requirements on the package of one prop that is handed over by itself, which a scene is not.
OF_SINGLE_PROPS = {
    "com.nvidia.usd.AA.001": "Everything lies below one root: scenes share assets, which lie beside them.",
    "com.nvidia.simready.NP.005": "The file is called as its folder: every scene is called scene.usda.",
    "com.nvidia.simready.SR.002": "A thumbnail of 256 x 256: a scene has previews of its own size.",
    "com.nvidia.simready.SR.004": "Mass, category and licence of the prop: each asset of a scene carries its own.",
}
# Words of a layer that holds a body and a mesh.
DEMANDED = (b"PhysicsRigidBodyAPI", b"def Mesh")
UNOPENED = "scene.usda or scene_nested.usda does not open"
FILE, LIST = "scene.urdf", "scene.json"


class PassedLayers(Protocol):
    """Memory of layers of assets that passed SimReady's rules, by a digest of their content."""

    def has(self, digest: str) -> bool:
        """True if a layer of that digest passed."""

    def add(self, digests: Collection[str]) -> None:
        """Remember layers that passed."""


@dataclass(frozen=True, eq=False)
class SceneFiles:
    """Files in the same folder as `scene.xml`, each read once; a subject is equal to itself alone.

    `passed_layers`: layers that need not be checked by SimReady's rules again; None: all are checked.
    """

    scene_subject: SceneSubject
    passed_layers: PassedLayers | None = None

    @property
    def usd(self) -> Path:
        """The root layer."""
        return self.scene_subject.root / USD_FILE

    @property
    def nested(self) -> Path:
        """The layer that refers to the root layer and nests the bodies."""
        return self.scene_subject.root / NESTED_FILE

    @property
    def light(self) -> Path:
        """The light form: primitive shapes, without pictures."""
        return self.scene_subject.root / LIGHT_FILE

    @cached_property
    def composed(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The stage, or None if it does not exist or open, and the errors and warnings of USD while it composes."""
        return _composed(self.usd)

    @cached_property
    def composed_nested(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The same of the layer with nested bodies."""
        return _composed(self.nested)

    @cached_property
    def imported(self) -> Loaded:
        """The stage as MuJoCo's own reader has it."""
        with quiet():
            return imported(self.usd)

    @cached_property
    def imported_nested(self) -> Loaded:
        """The same with nested bodies."""
        with quiet():
            return imported(self.nested)

    @cached_property
    def light_form(self) -> Loaded:
        """The light form compiled, with MuJoCo's warnings."""
        return load_asset_file(self.light)


def _composed(path: Path) -> tuple[Usd.Stage | None, tuple[str, ...]]:
    """The stage of a file, None if it does not exist or open, and what USD says while it composes."""
    with quiet():
        diagnostics = Diagnostics()
        try:
            stage = Usd.Stage.Open(str(path)) if path.is_file() else None
        except Tf.ErrorException as error:
            return None, (" ".join(str(error).split()),)
        return stage, tuple(diagnostics.take())


def formats_agree(files: SceneFiles, limit: float) -> Measurement:
    """SCN017: number of differing cells of files that can be read (SCN001, SCN018)."""
    missing = usd_facts.missing_importer()
    model, composed = files.scene_subject.loaded.model, (files.composed[0], files.composed_nested[0])
    flat, nested = (None, None) if missing else (files.imported.model, files.imported_nested.model)
    if model is None or composed[0] is None or composed[1] is None or (None in (flat, nested) and not missing):
        return not_run("one of scene.xml, scene.usda and scene_nested.usda cannot be read")
    expected = _read(lambda: mujoco_facts.facts_of_scene(model))
    problems = _disagreements(model, expected, flat, files.usd, composed[0])
    # The nested layer refers to the flat one, whose differences are its own; that is one fault.
    shared = {at for at, _ in problems}
    # Of a model that is the flat one again MuJoCo would be asked the same twice.
    apart = None if missing or _is_same(flat, nested) else nested
    of_nested = _disagreements(model, expected, apart, files.nested, composed[1])
    problems += [(f"nested/{at}", message) for at, message in of_nested if at not in shared]
    return not_run(missing, waived=True) if missing and not problems else count(problems, allowed=limit)


def _is_same(first: mujoco.MjModel, second: mujoco.MjModel) -> bool:
    """True where two models are the same numbers, and bodies, joints, geoms and sites have the same short names."""
    for part, other_part in ((first, second), (first.opt, second.opt)):
        for name in dir(part):
            # Where names begin in the text of all names differs: they are paths.
            if name.startswith(("_", "name")) or not isinstance(getattr(part, name), np.ndarray | float | int):
                continue
            one, other = (np.asarray(getattr(each, name)) for each in (part, other_part))
            if name not in LENGTHS and one.shape != other.shape:
                return False
            is_off = name not in LENGTHS and not bool((one == other).all())
            if is_off and float(np.abs(one.astype(float) - other.astype(float)).max()) > SAME:
                return False
    counts = {"body": first.nbody, "joint": first.njnt, "geom": first.ngeom, "site": first.nsite}
    return all(
        short_name(getattr(first, kind)(number).name) == short_name(getattr(second, kind)(number).name)
        for kind, count in counts.items()
        for number in range(count)
    )


def _disagreements(
    mjcf: mujoco.MjModel,
    reading: tuple[Cells | None, str],
    imported: mujoco.MjModel | None,
    usd: Path,
    stage: Usd.Stage,
) -> list[Problem]:
    """Differences between files that MuJoCo has read; `reading`: the table of scene.xml, or why there is none.

    `imported`: of the USD, composed as `stage`; None leaves what UsdPhysics reads.
    """
    expected, error = reading
    if expected is None:
        return [("scene.xml", error)]
    problems = []
    if imported is not None:
        rows = mujoco_facts.parameter_differences(mjcf, imported)
        problems += [row.problem for row in rows if row.exceeds(SCENE_TOLERANCE)]
    read, error = _read(lambda: usd_facts.StageReading(stage, scene=True))
    if read is None:
        return [*problems, (usd.name, error)]
    readers = [lambda: usd_facts.facts_of_scene_stage(read)]
    if imported is not None:
        readers.insert(0, lambda: usd_facts.facts_of_scene_import(imported, read))
    for reader in readers:
        actual, error = _read(reader)
        if actual is None:
            problems.append((usd.name, error))
        else:
            problems += compare(expected, actual, SCENE_TOLERANCE, SCENE_LENGTH_TOLERANCE_M)
    # What both readers of the USD find is reported once.
    return list(dict.fromkeys(problems))


def _read(reader: Callable[[], Facts]) -> tuple[Facts | None, str]:
    with quiet():
        try:
            return reader(), ""
        except (ValueError, Tf.ErrorException) as error:
            return None, " ".join(str(error).split()) or type(error).__name__


def usd_scene_loads_without_warnings(files: SceneFiles) -> Measurement:
    """SCN018: errors and warnings while the layers compose and MuJoCo reads them."""
    missing = missing_importer()
    flat = _loading_problems(files.usd.name, files.composed, None if missing else lambda: files.imported)
    if files.composed[0] is None:
        return _count(flat)
    # It refers to the flat one, whose messages are not repeated.
    shared = {message for _, message in flat}
    importer = None if missing else lambda: files.imported_nested
    nested = _loading_problems(files.nested.name, files.composed_nested, importer)
    problems = flat + [(name, message) for name, message in nested if message not in shared]
    return not_run(missing, waived=True) if missing and not problems else _count(problems)


def _loading_problems(
    name: str, composed: tuple[Usd.Stage | None, tuple[str, ...]], imported: Callable[[], Loaded] | None
) -> list[Problem]:
    """What USD and MuJoCo have to say of a layer; MuJoCo is not asked where `imported` is None."""
    stage, messages = composed
    if stage is None:
        return [(name, f"does not open: {'; '.join(messages) or 'there is no such file'}")]
    problems = [(name, f"USD says: {message}") for message in messages]
    if not stage.GetDefaultPrim():
        problems.append((name, "there is no default prim"))
    if imported is None:
        return problems
    loaded = imported()
    if loaded.model is None:
        problems.append((name, f"MuJoCo refuses it: {loaded.error}"))
    return problems + [(name, f"MuJoCo warns: {warning}") for warning in loaded.warnings]


def usd_scene_passes_openusd_validators(files: SceneFiles) -> Measurement:
    """SCN019: findings of OpenUSD's own validators."""
    stages = [files.composed[0], files.composed_nested[0]]
    if None in stages:
        return not_run(UNOPENED)
    with quiet():
        # What is wrong in the flat layer at a place that no body moves is found twice.
        return _count(list(dict.fromkeys(problem for stage in stages for problem in validator_findings(stage))))


def usd_scene_meets_simready_rules(files: SceneFiles) -> Measurement:
    """SCN020: failed requirements of SimReady Robotics-Prop 4.0.0, without those on a prop's package.

    The rules look at each prim by itself. A layer of an asset that passed in a kitchen is left out of the next ones,
    and of several copies all but the first; where what is left does not pass, the whole file is looked at.
    """
    if files.composed[0] is None:
        return not_run(UNOPENED)
    try:
        validator_python()
        if files.passed_layers is not None and _passes_without_known_layers(files, files.passed_layers):
            return _count([])
        _, failures = _validated(files.usd)
    except NoVerdict as error:
        return not_run(str(error), waived=error.is_missing)
    return _count(sorted((code, message) for code, message in failures.items() if code not in OF_SINGLE_PROPS))


def _validated(path: Path) -> Verdict:
    """Verdict on a layer in the folder of a scene. Raises NoVerdict."""
    with quiet():
        return validate_simready(path, path.parent, frozenset(OF_SINGLE_PROPS))


def _passes_without_known_layers(files: SceneFiles, known: PassedLayers) -> bool:
    """True if the scene passes with each layer once, and none of those that passed before. Raises NoVerdict."""
    part = files.usd.with_name(f".{os.getpid()}_{files.usd.name}")
    layer = Sdf.Layer.OpenAsAnonymous(str(files.usd))
    placed = {
        prim: [item.assetPath for item in prim.referenceList.GetAddedOrExplicitItems() if item.assetPath]
        for prim in layer.GetPrimAtPath(f"/{layer.defaultPrim}").nameChildren
    }
    layers = {path: (files.usd.parent / path).read_bytes() for paths in placed.values() for path in paths}
    # Of the content of a layer, in which pictures are named by theirs, and of what it is held against.
    versions = (f"{name}={version}" for name, version in sorted(validator_versions().items()))
    against = " ".join([PROFILE, PROFILE_VERSION, *versions]).encode()
    digests = {path: hashlib.sha256(against + data).hexdigest() for path, data in layers.items()}
    # The profile demands that there is a body and a mesh: the smallest layer that has both is always looked at.
    whole = [path for path, data in layers.items() if all(word in data for word in DEMANDED)]
    stays = min(whole, default="", key=lambda path: (len(layers[path]), path))
    seen: set[str] = set()
    for prim, paths in placed.items():
        named = {digests[path] for path in paths}
        is_known = bool(named) and all(digest in seen or known.has(digest) for digest in named)
        if is_known and (stays not in paths or named <= seen):
            prim.active = False
        seen |= named
    try:
        layer.Export(str(part))
        _, failures = _validated(part)
    finally:
        part.unlink(missing_ok=True)
    passes = not failures.keys() - OF_SINGLE_PROPS.keys()
    if passes:
        known.add(seen)
    return passes


def _count(problems: list[Problem]) -> Measurement:
    """The number of problems, of which the first twenty are listed."""
    return Measurement(float(len(problems)), tuple(problems[:MAX_LISTED]))


def scene_differences(folder: Path, scene: Scene) -> list[Problem]:
    """One problem for each cell in which the URDF files and scene.json of a folder differ from a scene."""
    problems: list[Problem] = []
    for asset in scene.assets:
        file = f"{asset.id}.urdf"
        problems += _below(file, urdf_facts.asset_differences(folder / file, asset))
    try:
        problems += _below(FILE, _tree_differences(folder, scene))
        problems += _below(LIST, _list_differences(folder, scene))
    except (OSError, ValueError, KeyError, TypeError) as error:
        problems.append((str(folder.name), f"cannot be read: {' '.join(str(error).split())}"))
    return problems


def _tree_differences(folder: Path, scene: Scene) -> Iterator[Problem]:
    """Differences of the fixed placements, one by one."""
    read = urdf_facts.read(folder / FILE)
    roots = {read.model.body(i).name: i for i in range(1, read.model.nbody) if not read.model.body_parentid[i]}
    fixed = [place for place in scene.placements if scene.asset_of[place.name].base is Base.FIXED]
    yield from (row.problem for row in text("placements", sorted(place.name for place in fixed), sorted(roots)))
    for place in fixed:
        if place.name not in roots:
            continue
        asset, body = scene.asset_of[place.name], roots[place.name]
        aside = urdf_facts.beside(folder / f"{asset.id}.urdf")
        yield from _below(place.name, urdf_facts.table_differences(UrdfAsset(read, aside, place.name), asset))
        found = {"position": three(read.model.body_pos[body]), "quaternion": four(read.model.body_quat[body])}
        expected = frame(place.pose @ asset.root.pose)
        yield from _below(place.name, compare(expected, found, TOLERANCE, LENGTH_TOLERANCE_M))


def _list_differences(folder: Path, scene: Scene) -> Iterator[Problem]:
    """Differences of scene.json: placements, their poses and the positions of their joints."""
    rows = {row["name"]: row for row in json.loads((folder / LIST).read_text(encoding="ascii"))["placements"]}
    yield from (row.problem for row in text("placements", [place.name for place in scene.placements], list(rows)))
    for place in scene.placements:
        if place.name in rows:
            asset = scene.asset_of[place.name]
            expected = {
                "asset": asset.id,
                "urdf": f"{asset.id}.urdf",
                "base": asset.base.value,
                "layer": place.layer.value,
                "joints": sorted(joint_positions(place.joints).items()),
                **frame(place.pose @ asset.root.pose),
            }
            row = rows[place.name]
            actual = {name: row[name] for name in expected} | {"joints": sorted(dict(row["joints"]).items())}
            yield from _below(place.name, compare(expected, actual, TOLERANCE, LENGTH_TOLERANCE_M))


def _below(at: str, problems: Iterable[Problem]) -> Iterator[Problem]:
    return ((f"{at}/{pointer}", message) for pointer, message in problems)
