"""Find faults of a scene's USD by independent validators: OpenUSD, SimReady, MuJoCo's importer.

A file that does not open at all is reported once, by `usd_scene_loads_without_warnings`; the others are then not run.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

from pxr import Sdf, Usd

from casa_assets.checks.check import Measurement, Problem, not_run
from casa_assets.checks.package.usd import validator_findings
from casa_assets.checks.readers.mujoco_facts import Loaded
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.usd_facts import missing_importer
from casa_assets.checks.scene.formats.light_form import PassedLayers, SceneFiles
from casa_assets.checks.simready import PROFILE, PROFILE_VERSION, Verdict, validate_simready
from casa_assets.checks.simready_python import NoVerdict, validator_python, validator_versions

# Requirements on the package of one prop that is handed over by itself, which a scene is not.
OF_SINGLE_PROPS = {
    "com.nvidia.usd.AA.001": "Everything lies below one root: scenes share assets, which lie beside them.",
    "com.nvidia.simready.NP.005": "The file is called as its folder: every scene is called scene.usda.",
    "com.nvidia.simready.SR.002": "A thumbnail of 256 x 256: a scene has previews of its own size.",
    "com.nvidia.simready.SR.004": "Mass, category and licence of the prop: each asset of a scene carries its own.",
}
MAX_LISTED = 20
# Words of a layer that holds a body and a mesh.
DEMANDED = (b"PhysicsRigidBodyAPI", b"def Mesh")
UNREADABLE = "scene.usda or scene_nested.usda does not open"


def usd_scene_loads_without_warnings(files: SceneFiles) -> Measurement:
    """SCN018: errors and warnings while the layers compose and MuJoCo reads them."""
    missing = missing_importer()
    flat = _loading_problems(files.usd.name, files.composed, None if missing else lambda: files.imported)
    if files.composed[0] is None:
        return _count(flat)
    # It refers to the flat one: what was said of that is not said again.
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
        return not_run(UNREADABLE)
    with quiet():
        # What is wrong in the flat layer at a place that no body moves is found twice.
        return _count(list(dict.fromkeys(problem for stage in stages for problem in validator_findings(stage))))


def usd_scene_meets_simready_rules(files: SceneFiles) -> Measurement:
    """SCN020: failed requirements of SimReady Robotics-Prop 4.0.0, without those on a prop's package.

    The rules look at each prim by itself. A layer of an asset that passed in a kitchen is left out of the next ones,
    and of several copies in one kitchen all but the first; where what is left does not pass, the whole file is looked
    at.
    """
    if files.composed[0] is None:
        return not_run(UNREADABLE)
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
    """True if the scene passes with each layer of an asset once, and none of those that passed before.

    Raises:
        NoVerdict: the validator failed.
    """
    part = files.usd.with_name(f".{os.getpid()}_{files.usd.name}")
    layer = Sdf.Layer.OpenAsAnonymous(str(files.usd))
    placed = {
        prim: [item.assetPath for item in prim.referenceList.GetAddedOrExplicitItems() if item.assetPath]
        for prim in layer.GetPrimAtPath(f"/{layer.defaultPrim}").nameChildren
    }
    layers = {path: (files.usd.parent / path).read_bytes() for paths in placed.values() for path in paths}
    digests = {path: _digest(data) for path, data in layers.items()}
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


def _digest(layer: bytes) -> str:
    """Digest of the content of a layer, and of what it is held against. Pictures in it are named by their content."""
    held_against = " ".join([PROFILE, PROFILE_VERSION, *(f"{k}={v}" for k, v in sorted(validator_versions().items()))])
    return hashlib.sha256(held_against.encode() + layer).hexdigest()


def _count(problems: list[Problem]) -> Measurement:
    """The number of problems, of which the first twenty are listed."""
    return Measurement(float(len(problems)), tuple(problems[:MAX_LISTED]))
