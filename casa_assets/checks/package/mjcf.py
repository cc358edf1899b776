"""Find MJCF packages that do not compile, break conventions, contradict the asset or do not come to rest."""

from __future__ import annotations

from pathlib import Path

from casa_assets.checks.asset.applicability import NO_COMPILE, NO_JOINTS
from casa_assets.checks.check import Measurement, all_at_most, at_most, count, not_applicable, not_run
from casa_assets.checks.motion import sweep
from casa_assets.checks.motion.drop import TUNNEL_M, DropProtocol, DropResult, drop_on_floor
from casa_assets.checks.package import fact_differences, robosuite_conventions
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import asset_facts, mujoco_facts, mujoco_load
from casa_assets.model.asset.asset import Base
from casa_assets.model.registry.category import RestingPose

# MJC001 alone reports what cannot be read or compiled; the other checks are then not run.
NEITHER_COMPILES = "neither file compiles"
NEVER_RESTED = "it never came to rest"


def mjcf_compiles(package: Package) -> Measurement:
    """MJC001: number of files that do not compile."""
    errors = {path.name: mujoco_load.load_mjcf(path).error for path in _files(package)}
    return count((name, f"does not compile: {error}") for name, error in errors.items() if error)


def mjcf_compiles_without_warnings(package: Package) -> Measurement:
    """MJC002: number of warnings of MuJoCo."""
    paths = _compiling(package)
    if not paths:
        return not_run(NEITHER_COMPILES)
    return count((path.name, text) for path in paths for text in mujoco_load.load_mjcf(path).warnings)


def mjcf_follows_conventions(package: Package) -> Measurement:
    """MJC003: number of names, groups, sizes and files against robosuite's and robocasa's conventions."""
    if package.mjcf not in _compiling(package):
        return not_run(NO_COMPILE)
    return count(robosuite_conventions.faults(package.mjcf))


def visuals_are_massless(package: Package) -> Measurement:
    """MJC004: number of visuals that have mass or collide."""
    paths = _compiling(package)
    if not paths:
        return not_run(NEITHER_COMPILES)
    return count(fault for path in paths for fault in robosuite_conventions.visual_faults(path))


def mjcf_equals_record(package: Package, limit: float) -> Measurement:
    """MJC005: largest difference between the compiled files and the facts of the asset."""
    paths = _compiling(package)
    if not paths:
        return not_run(NEITHER_COMPILES)
    expected = asset_facts.facts(package.asset)
    worst, problems = 0.0, []
    for path in paths:
        try:
            actual = mujoco_facts.facts(path)
        except ValueError as error:
            problems.append((path.name, str(error)))
            continue
        compared = fact_differences.agree(expected, actual, limit)
        worst = max(worst, compared.number or 0.0)
        problems += [(f"{path.name}/{pointer}", message) for pointer, message in compared.problems]
    return Measurement(worst, tuple(problems))


def comes_to_rest_after_drop(package: Package, limit: float, *protocol: float) -> Measurement:
    """MJC006: seconds until rest after a drop from twice the height, without falling through the floor."""
    drop = _drop(package, DropProtocol(*protocol))
    if isinstance(drop, Measurement):
        return drop
    problems = [("scene.xml", f"simulation in trouble: {warning}") for warning in drop.warnings]
    if drop.rest_s is None or drop.rest_s + DropProtocol(*protocol).rest_s > limit:
        problems.append(("scene.xml", f"is not at rest {limit:g} s after it was dropped"))
    if drop.deepest_m > TUNNEL_M:
        problems.append(("scene.xml", f"sank {drop.deepest_m:.3f} m into the floor"))
    return Measurement(drop.rest_s, tuple(problems))


def stays_upright_after_drop(package: Package, limit: float, *protocol: float) -> Measurement:
    """MJC007: tilt after the drop, degrees."""
    if package.category.upright is RestingPose.ANY:
        return not_applicable(f"a {package.category.id} lies as it falls")
    drop = _drop(package, DropProtocol(*protocol))
    if isinstance(drop, Measurement):
        return drop
    if drop.rest_s is None:
        return not_run(NEVER_RESTED)
    return at_most(drop.tilt_deg, limit, "scene.xml", f"tipped by {drop.tilt_deg:.1f} degrees")


def rests_on_floor_after_drop(package: Package, limit: float, *protocol: float) -> Measurement:
    """MJC008: deepest penetration of the floor at rest, metres."""
    drop = _drop(package, DropProtocol(*protocol))
    if isinstance(drop, Measurement):
        return drop
    if drop.rest_s is None:
        return not_run(NEVER_RESTED)
    return at_most(drop.rest_m, limit, "scene.xml", f"rests {drop.rest_m:.4f} m inside the floor")


def joints_move_without_collision(package: Package, limit: float) -> Measurement:
    """MJC009: deepest contact between parts while each joint moves through its range, metres."""
    if not package.asset.joints:
        return not_applicable(NO_JOINTS)
    depths = {f"joints/{name}": depth for name, depth in sweep.deepest_contacts(package.scene).items()}
    if not depths:
        return not_run("scene.xml does not compile")
    return all_at_most(depths, limit, "its part sinks {:.4f} m into another on the way", NO_JOINTS)


def _files(package: Package) -> tuple[Path, Path]:
    return package.mjcf, package.scene


def _compiling(package: Package) -> list[Path]:
    return [path for path in _files(package) if not mujoco_load.load_mjcf(path).error]


def _drop(package: Package, protocol: DropProtocol) -> DropResult | Measurement:
    """Result of the drop, or of a check that has none to look at."""
    if package.asset.base is not Base.FREE:
        return not_applicable("it is fixed in its place and cannot fall")
    drop = drop_on_floor(package.scene, protocol)
    return not_run("scene.xml does not compile or holds nothing free") if drop is None else drop
