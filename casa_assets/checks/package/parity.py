"""Find differences between the MJCF and the USD of one asset, and between an asset and its URDF."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import mujoco
import numpy as np
from pxr import Tf

from casa_assets.checks.check import Measurement, Problem, not_run
from casa_assets.checks.package import Package
from casa_assets.checks.readers import mujoco_facts, urdf_facts, usd_facts
from casa_assets.checks.readers.facts import (
    AssetFacts,
    Difference,
    asset_facts,
    differences,
    measured,
    relative,
    short_name,
)
from casa_assets.checks.readers.mujoco_facts import FREE_JOINT, colliders_of, resistance
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.urdf_facts import UrdfAsset
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Asset
from casa_assets.model.record import Record

# Parity ---------------------------------------------------------------------------------------------------------------
# Find differences between the MJCF and the USD of one asset, its nested layer too where it has one.
#
# Where one of the files does not load, the checks of that format report it, and those of parity are not run.

UNREADABLE = "one of the files cannot be read"
T = TypeVar("T")
ANGLE_TOLERANCE_DEG = 1e-4


def compare(expected: Record, actual: Record, tolerance: float, length_m: float) -> list[Problem]:
    """One problem for each cell in which two tables, of assets or of scenes, differ by more than they may.

    Args:
        expected, actual: what it should be, and what it is.
        tolerance: of ratios, unit vectors, radians and of masses and moments relative to those of the body.
        length_m: tolerance of lengths, metres.
    """
    limits = {"gravity": 10 * tolerance, "fov_y_deg": ANGLE_TOLERANCE_DEG, "cone_deg": ANGLE_TOLERANCE_DEG}
    return [
        row.problem
        for row in differences(expected, actual)
        if row.exceeds(length_m if row.is_length else limits.get(row.pointer.rsplit("/", 1)[-1], tolerance))
    ]


def mujoco_reads_both_alike(package: Package, limit: float) -> Measurement:
    """PAR001: largest difference, other than of lengths, between MuJoCo's readings of MJCF and USD."""
    if missing := usd_facts.missing_importer():
        return not_run(missing, waived=True)
    rows = _compare_files(package, usd_facts.mujoco_facts)
    return not_run(UNREADABLE) if rows is None else measured((r for r in rows if not r.is_length), limit)


def openusd_reads_as_mujoco(package: Package, limit: float) -> Measurement:
    """PAR002: largest difference, other than of lengths, between UsdPhysics' reading of the USD and the MJCF."""
    rows = _compare_files(package, usd_facts.pxr_facts)
    return not_run(UNREADABLE) if rows is None else measured((r for r in rows if not r.is_length), limit)


def lengths_agree(package: Package, limit: float) -> Measurement:
    """PAR004: largest difference of positions, sizes and travels between both readers, metres."""
    missing = usd_facts.missing_importer()
    by_mujoco = [] if missing else _compare_files(package, usd_facts.mujoco_facts)
    by_openusd = _compare_files(package, usd_facts.pxr_facts)
    if by_mujoco is None or by_openusd is None:
        return not_run(UNREADABLE)
    found = measured((r for r in (*by_mujoco, *by_openusd) if r.is_length), limit)
    return not_run(missing, waived=True) if missing and not found.problems else found


def contact_parameters_agree(package: Package, limit: float) -> Measurement:
    """PAR003: largest relative difference of contact and joint parameters."""
    if missing := usd_facts.missing_importer():
        return not_run(missing, waived=True)
    mjcf = mujoco_facts.load_mjcf(package.mjcf).model if package.mjcf.is_file() else None
    rows: list[Difference] = []
    for path in package.usd_files:
        usd = _read_quietly(lambda path: usd_facts.imported(path).model, path)
        if mjcf is None or usd is None:
            return not_run(UNREADABLE)
        rows += parameter_differences(parameter_table(mjcf), parameter_table(usd))
    return measured(rows, limit)


def parameter_differences(expected: dict[str, Floats], actual: dict[str, Floats]) -> list[Difference]:
    """Differences of the parameters that two models have in common, relative to the larger of two numbers."""
    return [relative(key, expected[key], actual[key]) for key in sorted(expected.keys() & actual.keys())]


def parameter_table(model: mujoco.MjModel) -> dict[str, Floats]:
    """Contact and joint parameters of a model, by pointer.

    Of a body one row per collider, in an order that does not depend on names; of a joint one row.
    """
    table: dict[str, Floats] = {}
    # (ngeom, 14)
    plain = (model.geom_contype, model.geom_conaffinity, model.geom_condim, model.geom_priority)
    soft = (model.geom_solmix, model.geom_margin, model.geom_gap)
    contacts = np.column_stack([*plain, *soft, model.geom_solref, model.geom_solimp])
    for body in range(1, model.nbody):
        rows = sorted(contacts[colliders_of(model, body)].tolist())
        if rows:
            table[f"bodies/{short_name(model.body(body).name)}/contacts"] = np.array(rows)
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) != FREE_JOINT:
            dof = int(model.jnt_dofadr[joint])
            # How dry friction gives way: solref and solimp.
            yielding = (*model.dof_solref[dof], *model.dof_solimp[dof])
            table[f"joints/{short_name(model.joint(joint).name)}"] = np.array((*resistance(model, joint), *yielding))
    return table


def _compare_files(package: Package, read_usd: Callable[[Path], AssetFacts]) -> list[Difference] | None:
    """Differences of the MJCF and each layer of the USD; None if one of them cannot be read."""
    expected = _read_quietly(mujoco_facts.facts, package.mjcf)
    rows: list[Difference] = []
    for path in package.usd_files:
        actual = _read_quietly(read_usd, path)
        if expected is None or actual is None:
            return None
        rows += differences(expected, actual)
    return rows


def _read_quietly(read: Callable[[Path], T], path: Path) -> T | None:
    """Result of a reader on a file, or None if it fails."""
    if not path.is_file():
        return None
    with quiet():
        try:
            return read(path)
        except (ValueError, Tf.ErrorException):
            return None


# Urdf -----------------------------------------------------------------------------------------------------------------

# Of ratios, unit vectors and radians: a URDF has nine digits of a number.
TOLERANCE = 1e-6
LENGTH_TOLERANCE_M = 1e-6  # a float32 six metres from the origin is right to 2.4e-7


def asset_differences(path: Path, asset: Asset) -> list[Problem]:
    """One problem for each cell in which a URDF differs from the asset that it was written from.

    Args:
        path: of the URDF; the JSON and the folders that it names are in the same folder.
    """
    try:
        return table_differences(UrdfAsset(urdf_facts.read(path), urdf_facts.beside(path)), asset)
    except (ValueError, KeyError, TypeError) as error:
        return [(path.name, f"cannot be read: {' '.join(str(error).split())}")]


def table_differences(written: UrdfAsset, asset: Asset) -> list[Problem]:
    """Differences between a written asset and the asset: the table of facts, and the bounds of each visual.

    Raises:
        ValueError, KeyError, TypeError: the files do not say what a table needs.
    """
    expected = urdf_facts.on_joint_axes(asset_facts(asset))
    problems = compare(expected, written.table(), TOLERANCE, LENGTH_TOLERANCE_M)
    # Names of visuals are compared with the looks.
    found = written.visual_bounds()
    for link in asset.links:
        joint = asset.joint_of(link.name)
        anchor = np.array(joint.anchor if joint else (0.0, 0.0, 0.0))
        for visual in link.visuals:
            off = float(np.abs(found.get(visual.name, np.inf) - (visual.mesh.bounds - anchor)).max())
            if not off <= LENGTH_TOLERANCE_M:
                problems.append((f"visuals/{visual.name}", f"its bounds differ by {off:.3g} m"))
    return problems
