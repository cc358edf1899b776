"""Find differences between the MJCF and the USD of one asset.

What one of the two files does not load is said by the checks of that format; parity then has nothing to add.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple, TypeVar

import mujoco
import numpy as np
import numpy.typing as npt
from pxr import Tf

from casa_assets.checks.check import Measurement, not_run
from casa_assets.checks.package.fact_differences import Difference, differences, ratio
from casa_assets.checks.package.facts import AssetFacts
from casa_assets.checks.package.package import Package
from casa_assets.checks.readers import mjcf_facts, mujoco_load, usd_facts
from casa_assets.checks.readers.mujoco_facts import FREE_JOINT, collides, resistance, short_name
from casa_assets.checks.readers.quiet import quiet
from casa_assets.model.asset.asset import JointKind

UNREAD = "one of the two files cannot be read"
T = TypeVar("T")
Values = npt.NDArray[np.float64]
# Cells of the table in metres; a range is one where the joint slides.
LENGTHS = frozenset({"position", "center_of_mass", "lower", "upper", "anchor", "size"})


class FactDifference(NamedTuple):
    """A difference and whether it is a length."""

    difference: Difference
    length: bool


def compare(left: AssetFacts, right: AssetFacts, relative: float, length: float) -> list[tuple[str, str]]:
    """(pointer, message) for each cell in which two tables differ by more than they may.

    Args:
        left, right: what it should be, and what it is.
        relative: tolerance of ratios, unit vectors, radians and of masses and moments relative to those of the body.
        length: tolerance of lengths, metres.
    """
    rows = list(_rows(left, right))
    return [(r.difference.pointer, r.difference.message) for r in rows if _exceeds(r, length if r.length else relative)]


def mujoco_reads_both_alike(package: Package, limit: float | None) -> Measurement:
    """PAR001: largest difference, other than of lengths, between MuJoCo's readings of MJCF and USD."""
    rows = _between(package, usd_facts.mujoco_facts)
    return not_run(UNREAD) if rows is None else _measured([r for r in rows if not r.length], limit)


def openusd_reads_as_mujoco(package: Package, limit: float | None) -> Measurement:
    """PAR002: largest difference, other than of lengths, between UsdPhysics' reading of the USD and the MJCF."""
    rows = _between(package, usd_facts.pxr_facts)
    return not_run(UNREAD) if rows is None else _measured([r for r in rows if not r.length], limit)


def lengths_agree(package: Package, limit: float | None) -> Measurement:
    """PAR004: largest difference of positions, sizes and travels between both readers, metres."""
    one, other = _between(package, usd_facts.mujoco_facts), _between(package, usd_facts.pxr_facts)
    if one is None or other is None:
        return not_run(UNREAD)
    return _measured([r for r in (*one, *other) if r.length], limit)


def contact_parameters_agree(package: Package, limit: float | None) -> Measurement:
    """PAR003: largest relative difference of contact and joint parameters."""
    mjcf = mujoco_load.load_mjcf(package.mjcf).model if package.mjcf.is_file() else None
    usd = _quietly(lambda path: usd_facts.imported(path).model, package.usd)
    if mjcf is None or usd is None:
        return not_run(UNREAD)
    return _measured([FactDifference(d, False) for d in parameters(mjcf, usd)], limit)


def parameters(ours: mujoco.MjModel, theirs: mujoco.MjModel) -> list[Difference]:
    """Contact and joint parameters of what two models have in common, relative to the larger of two numbers."""
    left, right = _parameters(ours), _parameters(theirs)
    return [_differ(key, left[key], right[key]) for key in sorted(left.keys() & right.keys())]


def _between(package: Package, read: Callable[[Path], AssetFacts]) -> list[FactDifference] | None:
    """Differences of the two files; None where one of them cannot be read."""
    left = _quietly(mjcf_facts.facts, package.mjcf)
    right = _quietly(read, package.usd)
    return None if left is None or right is None else list(_rows(left, right))


def _quietly(read: Callable[[Path], T], path: Path) -> T | None:
    """Result of a reader on a file, or None where it fails."""
    if not path.is_file():
        return None
    with quiet():
        try:
            return read(path)
        except (ValueError, Tf.ErrorException):
            return None


def _rows(left: AssetFacts, right: AssetFacts) -> Iterator[FactDifference]:
    slides = {b.name for b in left.bodies if b.joint is not None and b.joint.kind is JointKind.SLIDE}
    for difference in differences(left, right):
        cell = difference.pointer.rsplit("/", 1)[-1]
        slide = cell == "range" and difference.pointer.split("/")[1] in slides
        yield FactDifference(difference, difference.size is not None and (cell in LENGTHS or slide))


def _exceeds(row: FactDifference, tolerance: float) -> bool:
    size = row.difference.size
    return size is None or not size <= tolerance


def _measured(rows: list[FactDifference], limit: float | None) -> Measurement:
    assert limit is not None, "the row of this check names a limit"
    worst = max((r.difference.size for r in rows if r.difference.size is not None), default=0.0)
    faults = dict.fromkeys((r.difference.pointer, r.difference.message) for r in rows if _exceeds(r, limit))
    return Measurement(worst, tuple(faults))


def _parameters(model: mujoco.MjModel) -> dict[str, Values]:
    """Pointer -> numbers: one row per collider of a body, in an order that does not depend on names; one per joint."""
    table: dict[str, Values] = {}
    for body in range(1, model.nbody):
        start = int(model.body_geomadr[body])
        geoms = [g for g in range(start, start + int(model.body_geomnum[body])) if collides(model, g)]
        if geoms:
            rows = sorted(_contact(model, g) for g in geoms)
            table[f"bodies/{short_name(model.body(body).name)}/contacts"] = np.array(rows)
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) != FREE_JOINT:
            table[f"joints/{short_name(model.joint(joint).name)}"] = np.array(_friction_too(model, joint))
    return table


def _contact(model: mujoco.MjModel, geom: int) -> tuple[float, ...]:
    """(contype, conaffinity, condim, priority, solmix, margin, gap, solref, solimp) of a geom."""
    plain = (model.geom_contype, model.geom_conaffinity, model.geom_condim, model.geom_priority)
    soft = (model.geom_solmix, model.geom_margin, model.geom_gap)
    return (*(float(a[geom]) for a in (*plain, *soft)), *model.geom_solref[geom], *model.geom_solimp[geom])


def _friction_too(model: mujoco.MjModel, joint: int) -> tuple[float, ...]:
    """Resistance of a joint, and how its dry friction gives way: solref and solimp."""
    dof = int(model.jnt_dofadr[joint])
    return (*resistance(model, joint), *model.dof_solref[dof], *model.dof_solimp[dof])


def _differ(pointer: str, ours: Values, theirs: Values) -> Difference:
    message = f"is {_text(theirs)}, should be {_text(ours)}"
    if ours.shape != theirs.shape:
        return Difference(pointer, None, message)
    return Difference(pointer, ratio(ours, theirs), message)


def _text(values: Values) -> str:
    return "; ".join(" ".join(f"{v:.6g}" for v in row) for row in np.atleast_2d(values))
