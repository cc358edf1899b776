"""Find MJCF packages that do not compile, break conventions, contradict the asset or do not come to rest."""

from __future__ import annotations

from pathlib import Path

from casa_assets.checks.asset.built import NO_COMPILE, NO_JOINTS
from casa_assets.checks.check import Measurement, not_applicable, not_run, required_limit
from casa_assets.checks.motion import drop, sweep
from casa_assets.checks.package import fact_differences, robosuite_conventions
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import asset_facts, mjcf_facts, mujoco_load
from casa_assets.model.asset.asset import Base
from casa_assets.model.registry.category import RestingPose

# What cannot be read or compiled is told by MJC001 alone; the other checks are then not run.
FIXED = "it is fixed in its place and cannot fall"
NEITHER = "neither file compiles"


def mjcf_compiles(package: Package, limit: float | None) -> Measurement:
    """MJC001: number of files that do not compile."""
    errors = [(path.name, mujoco_load.load_mjcf(path).error) for path in _files(package)]
    problems = tuple((name, f"does not compile: {error}") for name, error in errors if error)
    return Measurement(float(len(problems)), problems)


def mjcf_compiles_without_warnings(package: Package, limit: float | None) -> Measurement:
    """MJC002: number of warnings of MuJoCo."""
    if not _compiled(package):
        return not_run(NEITHER)
    problems = tuple((path.name, said) for path in _compiled(package) for said in mujoco_load.load_mjcf(path).warnings)
    return Measurement(float(len(problems)), problems)


def mjcf_follows_conventions(package: Package, limit: float | None) -> Measurement:
    """MJC003: number of names, groups, sizes and files against robosuite's and robocasa's conventions."""
    if package.mjcf not in _compiled(package):
        return not_run(NO_COMPILE)
    problems = tuple(robosuite_conventions.faults(package.mjcf))
    return Measurement(float(len(problems)), problems)


def visuals_are_massless(package: Package, limit: float | None) -> Measurement:
    """MJC004: number of visuals that have mass or collide."""
    if not _compiled(package):
        return not_run(NEITHER)
    problems = tuple(fault for path in _compiled(package) for fault in robosuite_conventions.visual_faults(path))
    return Measurement(float(len(problems)), problems)


def mjcf_equals_record(package: Package, limit: float | None) -> Measurement:
    """MJC005: largest difference between the compiled files and the facts of the asset."""
    if not _compiled(package):
        return not_run(NEITHER)
    expected = asset_facts.facts(package.asset)
    worst, problems = 0.0, []
    for path in _compiled(package):
        try:
            found = mjcf_facts.facts(path)
        except ValueError as error:
            problems.append((path.name, str(error)))
            continue
        measured = fact_differences.agree(expected, found, required_limit(limit))
        worst = max(worst, measured.number or 0.0)
        problems += [(f"{path.name}/{pointer}", message) for pointer, message in measured.problems]
    return Measurement(worst, tuple(problems))


def comes_to_rest_after_drop(package: Package, limit: float | None, *how: float) -> Measurement:
    """MJC006: seconds until rest after a drop from twice the height, without falling through the floor."""
    protocol = drop.DropProtocol(*how)
    fall = _fall(package, protocol)
    if fall is None:
        return _unfallen(package, fall)
    problems = [("scene.xml", f"simulation in trouble: {said}") for said in fall.troubles]
    if fall.rest_s is None or fall.rest_s + protocol.rest_s > required_limit(limit):
        problems.append(("scene.xml", f"is not at rest {required_limit(limit):g} s after it was dropped"))
    if fall.deepest_m > drop.TUNNEL_M:
        problems.append(("scene.xml", f"sank {fall.deepest_m:.3f} m into the floor"))
    return Measurement(fall.rest_s, tuple(problems))


def stays_upright_after_drop(package: Package, limit: float | None, *how: float) -> Measurement:
    """MJC007: tilt after the drop, degrees."""
    protocol = drop.DropProtocol(*how)
    fall = _fall(package, protocol)
    if package.category.upright is RestingPose.ANY:
        return not_applicable(f"a {package.category.id} lies as it falls")
    if fall is None or fall.rest_s is None:
        return _unfallen(package, fall)
    problems = (
        (("scene.xml", f"tipped by {fall.tilt_deg:.1f} degrees"),) if fall.tilt_deg > required_limit(limit) else ()
    )
    return Measurement(fall.tilt_deg, problems)


def rests_on_floor_after_drop(package: Package, limit: float | None, *how: float) -> Measurement:
    """MJC008: deepest penetration of the floor at rest, metres."""
    protocol = drop.DropProtocol(*how)
    fall = _fall(package, protocol)
    if fall is None or fall.rest_s is None:
        return _unfallen(package, fall)
    problems = (
        (("scene.xml", f"rests {fall.rest_m:.4f} m inside the floor"),) if fall.rest_m > required_limit(limit) else ()
    )
    return Measurement(fall.rest_m, problems)


def joints_move_without_collision(package: Package, limit: float | None) -> Measurement:
    """MJC009: deepest contact between parts while each joint moves through its range, metres."""
    if not package.asset.joints:
        return not_applicable(NO_JOINTS)
    depths = sweep.deepest(package.scene)
    problems = tuple(
        (f"joints/{name}", f"its part sinks {depth:.4f} m into another on the way")
        for name, depth in depths.items()
        if depth > required_limit(limit)
    )
    return Measurement(max(depths.values()), problems) if depths else not_run("scene.xml does not compile")


def _files(package: Package) -> tuple[Path, Path]:
    return package.mjcf, package.scene


def _compiled(package: Package) -> list[Path]:
    return [path for path in _files(package) if not mujoco_load.load_mjcf(path).error]


def _fall(package: Package, protocol: drop.DropProtocol) -> drop.DropResult | None:
    return drop.drop_on_floor(package.scene, protocol) if package.asset.base is Base.FREE else None


def _unfallen(package: Package, fall: drop.DropResult | None) -> Measurement:
    """Result where there is no rest after a fall to look at, with the reason."""
    if package.asset.base is not Base.FREE:
        return not_applicable(FIXED)
    return not_run("it never came to rest" if fall else "scene.xml does not compile or holds nothing free")
