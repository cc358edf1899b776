"""Find faults of a scene's USD by independent validators: OpenUSD, SimReady, MuJoCo's importer.

What does not open at all is said once, by `usd_scene_loads_without_warnings`; the others have nothing to add to that.
"""

from __future__ import annotations

import simready.validate
from pxr import UsdValidation

from casa_assets.checks.check import Measurement, not_run
from casa_assets.checks.package.usd import PROFILE, PROFILE_VERSION, load_rules, sites, validators
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.scene.formats.files import SceneFiles

# Requirements on the package of one prop that is handed over by itself, which a scene is not.
OF_SINGLE_PROPS = {
    "com.nvidia.usd.AA.001": "Everything lies below one root: scenes share assets, which lie beside them.",
    "com.nvidia.simready.NP.005": "The file is called as its folder: every scene is called scene.usda.",
    "com.nvidia.simready.SR.002": "A thumbnail of 256 x 256: a scene has previews of its own size.",
    "com.nvidia.simready.SR.004": "Mass, category and licence of the prop: each asset of a scene carries its own.",
}
LISTED = 20
CLOSED = "scene.usda does not open"


def usd_scene_loads_without_warnings(files: SceneFiles, limit: float | None) -> Measurement:
    """SCN018: errors, warnings and complaints while the layer composes and MuJoCo reads it."""
    assert limit is None
    stage, said = files.composed
    name = files.usd.name
    if stage is None:
        return _measured([(name, f"does not open: {'; '.join(said) or 'there is no such file'}")])
    problems = [(name, f"USD says: {message}") for message in said]
    if not stage.GetDefaultPrim():
        problems.append((name, "there is no default prim"))
    loaded = files.imported
    if loaded.model is None:
        problems.append((name, f"MuJoCo refuses it: {loaded.error}"))
    return _measured(problems + [(name, f"MuJoCo warns: {warning}") for warning in loaded.warnings])


def usd_scene_passes_openusd_validators(files: SceneFiles, limit: float | None) -> Measurement:
    """SCN019: findings of OpenUSD's own validators."""
    assert limit is None
    stage = files.composed[0]
    if stage is None:
        return not_run(CLOSED)
    with quiet():
        errors = UsdValidation.ValidationContext(validators()).Validate(stage)
        problems = sorted((sites(error), error.GetMessage()) for error in errors)
    return _measured(problems)


def usd_scene_meets_simready_rules(files: SceneFiles, limit: float | None) -> Measurement:
    """SCN020: failed requirements of SimReady Robotics-Prop 4.0.0, without those on a prop's package."""
    assert limit is None
    if files.composed[0] is None:
        return not_run(CLOSED)
    with quiet():
        load_rules()
        result = simready.validate.validate_asset(
            simready.validate.AssetValidationConfig(
                asset_path=str(files.usd), profile_id=PROFILE, profile_version=PROFILE_VERSION
            )
        )
    if result is None:
        return not_run("the validator of SimReady gave no verdict")
    failed: dict[str, str] = {}
    for issue in result.issues:
        code = issue.requirement.code if issue.requirement else str(issue.rule)
        if code not in OF_SINGLE_PROPS:
            failed.setdefault(code, issue.message)
    return _measured(sorted(failed.items()))


def _measured(problems: list[tuple[str, str]]) -> Measurement:
    return Measurement(float(len(problems)), tuple(problems[:LISTED]))
