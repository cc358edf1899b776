"""Find faults of the USD package, by OpenUSD, SimReady and MuJoCo's importer, and differences between it and the MJCF.

A file that does not open at all is reported once, by `usd_opens`; the other checks are then not run.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TypeVar

from PIL import Image
from pxr import Tf, Usd, UsdShade, UsdUtils, UsdValidation

from casa_assets.checks.check import Measurement, Package, Problem, Unmeasured, count, not_run
from casa_assets.checks.readers import mujoco_facts, usd_facts
from casa_assets.checks.readers.facts import Cells, Difference, differences, measured
from casa_assets.checks.readers.usd_facts import imported, missing_importer
from casa_assets.checks.simready import PROFILE, PROFILE_VERSION, quiet, validate_simready
from casa_assets.checks.simready_python import NoVerdict

T = TypeVar("T")
THUMBNAIL_PX = (256, 256)
# This validator looks shaders up in definitions that the usd-core wheel does not carry, and fails on any file.
UNAVAILABLE = frozenset({"usdShadeValidators:ShaderSdrCompliance"})


def usd_opens(package: Package) -> Measurement:
    """USD001: its layers parse and compose, without complaint, to stages with a default prim."""
    problems: list[Problem] = []
    for path in package.usd_files:
        if not path.is_file():
            problems.append(("usd", f"{path.name} does not exist"))
            continue
        with quiet():
            diagnostics = Diagnostics()
            stage = open_stage(path)
            messages = diagnostics.take()
        if stage is None:
            problems.append(("usd", f"{path.name} does not open: {'; '.join(messages) or 'no reason given'}"))
            continue
        problems += [("usd", message) for message in messages]
        if not stage.GetDefaultPrim():
            problems.append(("usd", "there is no default prim"))
    return count(problems)


def usd_meets_simready_profile(package: Package) -> Measurement:
    """USD002: failed requirements of SimReady Robotics-Prop 4.0.0, as its command line finds them."""
    with quiet():
        _opened(package.usd)
        try:
            passed, failures = validate_simready(package.usd, package.root)
        except NoVerdict as error:
            return not_run(str(error), waived=error.is_missing)
    if passed:
        return count([])
    return count(sorted(failures.items()) or [("simready", f"{PROFILE} {PROFILE_VERSION} does not apply")])


def usd_passes_openusd_validators(package: Package) -> Measurement:
    """USD003: findings of OpenUSD's own validators."""
    with quiet():
        stages = [_opened(path) for path in package.usd_files]
        return count(problem for stage in stages for problem in validator_findings(stage))


def validator_findings(stage: Usd.Stage) -> list[Problem]:
    """Findings of OpenUSD's own validators, sorted, at the paths of the prims that they are about."""
    problems = []
    for error in UsdValidation.ValidationContext(validators()).Validate(stage):
        prims = ", ".join(str(s.GetPrim().GetPath()) for s in error.GetSites() if s.IsPrim())
        problems.append((prims or "usd", error.GetMessage()))
    return sorted(problems)


def usd_imports_into_mujoco(package: Package) -> Measurement:
    """USD004: errors and warnings of MuJoCo's USD reader."""
    _need_importer()
    problems: list[Problem] = []
    for path in package.usd_files:
        with quiet():
            _opened(path)
            loaded = imported(path)
        if loaded.model is None:
            problems.append(("usd", f"MuJoCo refuses {path.name}: {loaded.error}"))
        problems += [("usd", f"MuJoCo warns of {path.name}: {warning}") for warning in loaded.warnings]
    return count(problems)


def usd_pictures_are_png(package: Package) -> Measurement:
    """USD005: every picture of a material lies in the package and is a PNG; the thumbnail is one of 256 x 256."""
    with quiet():
        stage, pictures = _opened(package.usd), []  # prims expire without their stage
        for prim in stage.Traverse():
            shader = UsdShade.Shader(prim)
            if shader and shader.GetIdAttr().Get() == "UsdUVTexture":
                value = shader.GetInput("file").Get()
                pictures.append((str(prim.GetPath()), value.path if value else ""))
    folder = package.usd.parent
    problems = [(prim, message) for prim, path in pictures if (message := _png_fault(folder, path))]
    thumbnail = f".thumbs/256x256/{package.usd.name}.png"
    message = _png_fault(folder, thumbnail)
    if not message and (size := Image.open(folder / thumbnail).size) != THUMBNAIL_PX:
        message = f"{thumbnail} measures {size[0]} x {size[1]} px"
    return count([*problems, ("thumbnail", message)] if message else problems)


class Diagnostics:
    """Gathers the errors and warnings of USD while it exists."""

    def __init__(self) -> None:
        self._delegate = UsdUtils.CoalescingDiagnosticDelegate()

    def take(self) -> list[str]:
        """The messages so far."""
        return [d.commentary for d in self._delegate.TakeUncoalescedDiagnostics()]


@cache
def validators() -> list[UsdValidation.Validator]:
    """OpenUSD's own validators that can run here."""
    found = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [v for v in found if v.GetMetadata().name not in UNAVAILABLE]


def open_stage(path: Path) -> Usd.Stage | None:
    """The stage of a file; None if it cannot be opened."""
    try:
        return Usd.Stage.Open(str(path)) or None
    except Tf.ErrorException:
        return None


def _opened(path: Path) -> Usd.Stage:
    """The stage of a file. Raises Unmeasured: it does not open."""
    stage = open_stage(path)
    if stage is None:
        raise Unmeasured(not_run("the USD file does not open"))
    return stage


def _need_importer() -> None:
    """Raise Unmeasured where MuJoCo cannot read USD."""
    if missing := missing_importer():
        raise Unmeasured(not_run(missing, waived=True))


def _png_fault(folder: Path, path: str) -> str:
    """Fault of a picture as text; empty if the picture is sound."""
    file = folder / path
    if not path or not file.is_file():
        return f"{path or 'the picture'} does not exist"
    try:
        with Image.open(file) as image:
            image.load()
            return "" if image.format == "PNG" else f"{path} is {image.format}, not PNG"
    except (OSError, SyntaxError) as fault:
        return f"{path} cannot be read: {fault}"


# Parity ---------------------------------------------------------------------------------------------------------------
# Differences between the MJCF and the USD, its nested layer too where it has one.


def mujoco_reads_both_alike(package: Package, limit: float) -> Measurement:
    """PAR001: largest difference, other than of lengths, between MuJoCo's readings of MJCF and USD."""
    _need_importer()
    return measured((r for r in _compare_files(package, usd_facts.mujoco_facts) if not r.is_length), limit)


def openusd_reads_as_mujoco(package: Package, limit: float) -> Measurement:
    """PAR002: largest difference, other than of lengths, between UsdPhysics' reading of the USD and the MJCF."""
    return measured((r for r in _compare_files(package, usd_facts.pxr_facts) if not r.is_length), limit)


def contact_parameters_agree(package: Package, limit: float) -> Measurement:
    """PAR003: largest relative difference of contact and joint parameters."""
    _need_importer()
    mjcf = mujoco_facts.load_mjcf(package.mjcf).model if package.mjcf.is_file() else None
    rows: list[Difference] = []
    for path in package.usd_files:
        usd = _read_quietly(lambda path: imported(path).model, path)
        rows += mujoco_facts.parameter_differences(_both(mjcf), _both(usd))
    return measured(rows, limit)


def lengths_agree(package: Package, limit: float) -> Measurement:
    """PAR004: largest difference of positions, sizes and travels between both readers, metres."""
    missing = missing_importer()
    by_mujoco = [] if missing else _compare_files(package, usd_facts.mujoco_facts)
    found = measured((r for r in (*by_mujoco, *_compare_files(package, usd_facts.pxr_facts)) if r.is_length), limit)
    return not_run(missing, waived=True) if missing and not found.problems else found


def _compare_files(package: Package, read_usd: Callable[[Path], Cells]) -> list[Difference]:
    """Differences of the MJCF and each layer of the USD. Raises Unmeasured: one of them cannot be read."""
    expected = _both(_read_quietly(mujoco_facts.facts, package.mjcf))
    rows: list[Difference] = []
    for path in package.usd_files:
        rows += differences(expected, _both(_read_quietly(read_usd, path)))
    return rows


def _both(read: T | None) -> T:
    """A reading. Raises Unmeasured: a file cannot be read."""
    if read is None:
        raise Unmeasured(not_run("one of the files cannot be read"))
    return read


def _read_quietly(read: Callable[[Path], T], path: Path) -> T | None:
    """Result of a reader on a file, or None if it fails."""
    if not path.is_file():
        return None
    with quiet():
        try:
            return read(path)
        except (ValueError, Tf.ErrorException):
            return None
