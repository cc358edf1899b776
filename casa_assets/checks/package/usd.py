"""Find faults of the USD package by independent validators: OpenUSD, SimReady, MuJoCo's importer.

What does not open at all is reported once, by `usd_opens`; the other checks have nothing to add to that and stay silent.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import simready.validate
from PIL import Image
from pxr import Tf, Usd, UsdShade, UsdUtils, UsdValidation
from simready.validate.api import features_summary_passed

from casa_assets.checks.check import Measurement, not_run
from casa_assets.checks.package import coincident_meshes
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.usd_facts import imported

CLOSED = "the USD file does not open"
PROFILE = "Robotics-Prop"
PROFILE_VERSION = "4.0.0"
THUMBNAIL_PX = (256, 256)
# It looks shaders up in definitions that the usd-core wheel does not carry, and fails on any file.
UNAVAILABLE = frozenset({"usdShadeValidators:ShaderSdrCompliance"})


def usd_opens(package: Package, _: float | None) -> Measurement:
    """USD001: the layer parses and composes, without complaint, to a stage with a default prim."""
    if not package.usd.is_file():
        return _measured([("usd", f"{package.usd.name} does not exist")])
    with quiet():
        delegate = Complaints()
        stage = _stage(package.usd)
        said = delegate.take()
    if stage is None:
        return _measured([("usd", f"{package.usd.name} does not open: {'; '.join(said) or 'no reason given'}")])
    problems = [("usd", message) for message in said]
    if not stage.GetDefaultPrim():
        problems.append(("usd", "there is no default prim"))
    return _measured(problems)


def usd_meets_simready_profile(package: Package, _: float | None) -> Measurement:
    """USD002: failed requirements of SimReady Robotics-Prop 4.0.0, as its command line finds them."""
    with quiet():
        if _stage(package.usd) is None:
            return not_run(CLOSED)
        load_rules()
        result = simready.validate.validate_asset(
            simready.validate.AssetValidationConfig(
                asset_path=str(package.usd), profile_id=PROFILE, profile_version=PROFILE_VERSION
            )
        )
    if result is None:
        return not_run("the validator of SimReady gave no verdict")
    # Not `passed` of the features: those that the profile calls optional say False where they are not used.
    if features_summary_passed(result.features_summary):
        return _measured([])
    failed: dict[str, str] = {}
    for issue in result.issues:
        failed.setdefault(issue.requirement.code if issue.requirement else str(issue.rule), issue.message)
    return _measured(sorted(failed.items()) or [("simready", f"{PROFILE} {PROFILE_VERSION} does not apply")])


def usd_passes_openusd_validators(package: Package, _: float | None) -> Measurement:
    """USD003: findings of OpenUSD's own validators."""
    with quiet():
        stage = _stage(package.usd)
        if stage is None:
            return not_run(CLOSED)
        errors = UsdValidation.ValidationContext(validators()).Validate(stage)
        problems = [(sites(error), error.GetMessage()) for error in errors]
    return _measured(sorted(problems))


def usd_imports_into_mujoco(package: Package, _: float | None) -> Measurement:
    """USD004: errors and warnings of MuJoCo's USD reader."""
    with quiet():
        if _stage(package.usd) is None:
            return not_run(CLOSED)
        loaded = imported(package.usd)
    if loaded.model is None:
        return _measured([("usd", f"MuJoCo refuses it: {loaded.error}")])
    return _measured([("usd", f"MuJoCo warns: {warning}") for warning in loaded.warnings])


def usd_pictures_are_png(package: Package, _: float | None) -> Measurement:
    """USD005: every picture of a material lies in the package and is a PNG; the thumbnail is one of 256 x 256."""
    with quiet():
        stage = _stage(package.usd)
        if stage is None:
            return not_run(CLOSED)
        named = list(_pictures(stage))
    folder = package.usd.parent
    problems = [(where, message) for where, path in named if (message := _not_png(folder, path))]
    thumbnail = f".thumbs/256x256/{package.usd.name}.png"
    message = _not_png(folder, thumbnail)
    if not message and (size := Image.open(folder / thumbnail).size) != THUMBNAIL_PX:
        message = f"{thumbnail} measures {size[0]} x {size[1]} px"
    return _measured(problems + ([("thumbnail", message)] if message else []))


@cache
def load_rules() -> None:
    """Register the rules of SimReady, once per process (0.2 s)."""
    with quiet():
        simready.validate.initialize([], [], [])
        coincident_meshes.make_swift()


class Complaints:
    """Gathers what USD complains of while it exists."""

    def __init__(self) -> None:
        self._delegate = UsdUtils.CoalescingDiagnosticDelegate()

    def take(self) -> list[str]:
        """The complaints so far."""
        return [d.commentary for d in self._delegate.TakeUncoalescedDiagnostics()]


@cache
def validators() -> list[UsdValidation.Validator]:
    """OpenUSD's own validators that can run here."""
    found = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [v for v in found if v.GetMetadata().name not in UNAVAILABLE]


def _stage(path: Path) -> Usd.Stage | None:
    try:
        return Usd.Stage.Open(str(path)) or None
    except Tf.ErrorException:
        return None


def sites(error: UsdValidation.ValidationError) -> str:
    """Paths of the prims that an error is about."""
    return ", ".join(str(s.GetPrim().GetPath()) for s in error.GetSites() if s.IsPrim()) or "usd"


def _pictures(stage: Usd.Stage) -> Iterator[tuple[str, str]]:
    """(path of the shader, path of the picture as written) for every texture."""
    for prim in stage.Traverse():
        shader = UsdShade.Shader(prim)
        if shader and shader.GetIdAttr().Get() == "UsdUVTexture":
            value = shader.GetInput("file").Get()
            yield str(prim.GetPath()), value.path if value else ""


def _not_png(folder: Path, path: str) -> str:
    """Fault of a picture, or nothing."""
    file = folder / path
    if not path or not file.is_file():
        return f"{path or 'the picture'} does not exist"
    try:
        with Image.open(file) as image:
            image.load()
            return "" if image.format == "PNG" else f"{path} is {image.format}, not PNG"
    except (OSError, SyntaxError) as fault:
        return f"{path} cannot be read: {fault}"


def _measured(problems: list[tuple[str, str]]) -> Measurement:
    return Measurement(number=float(len(problems)), problems=tuple(problems))
