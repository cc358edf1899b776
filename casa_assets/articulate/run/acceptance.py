"""Decide what a person has to look at before an articulated mesh is accepted, and whether it meets its contract."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from casa_assets.articulate.decisions import axis_word
from casa_assets.articulate.plan import Articulation, plan_confidence, weakest_part
from casa_assets.articulate.run.decisions import DECISIONS_NAME
from casa_assets.checks.package import Package
from casa_assets.checks.run import run
from casa_assets.checks.table.table import TABLE
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.issue import REVIEW_CODE, Issue, Severity
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.contract import Contract
from casa_assets.model.registry.rows import ConfidenceModel

# Contract -------------------------------------------------------------------------------------------------------------
# Decide whether an articulated mesh meets the RoboCasa contract of its category.
#
# An asset names a contract only where every check of it passes: names and paths, poses and states as MuJoCo operates
# them, and what a hand has to be able to move. Otherwise the failed checks are reported.

# What is there and how it is called; looked at first, for it costs nothing.
NAME_CODES = ("CON", "BEH001", "BEH002")
# How it moves and what it holds: rows that look at nothing but what a runtime operates.
MOTION_CODES = ("BEH003", "KIN", "HOL", "AST017")
# Of the faults that are kept with the asset.
MAX_LISTED_FAULTS = 6


def unmet_checks(
    asset: Asset, category: Category, root: Path, contract: Contract | None, limits: Mapping[str, float]
) -> tuple[str, ...]:
    """Return the failed checks of the contract that an asset names; empty where it meets it.

    Args:
        root: where its MJCF is written.
    """
    for codes in (NAME_CODES, MOTION_CODES):
        rows = [check for check in TABLE if check.code.startswith(codes) and check.severity is Severity.ERROR]
        subjects = asset, Package(asset, category, root, contract)
        issues = [i for subject in subjects for i in run(subject, asset.id, limits, table=rows).errors]
        if issues:
            return tuple(f"{i.code} {i.pointer}: {i.message}" if i.pointer else f"{i.code} {i.message}" for i in issues)
    return ()


def explanation(contract: str, known: Contract | None) -> str:
    """Return the sentence that says what an asset cannot be used for that does not meet a contract.

    Args:
        contract: id. known: its record, which names the fixture classes of RoboCasa that read it.
    """
    classes = sorted({name for names in (known.read_by.values() if known is not None else ()) for name in names})
    reader = f"RoboCasa's fixture class {' or '.join(classes)}" if classes else "RoboCasa"
    return f"contract {contract} not met: {reader} cannot use it; kitchens, MuJoCo and Isaac Sim can"


def without_contract(asset: Asset, faults: tuple[str, ...]) -> Asset:
    """Return the asset without a contract, with the reason in its provenance."""
    more = [f"and {len(faults) - MAX_LISTED_FAULTS} more"] if len(faults) > MAX_LISTED_FAULTS else []
    reason = "; ".join([*faults[:MAX_LISTED_FAULTS], *more])
    guess = Guess(subject="contract", value=f"not {asset.contract}", confidence=1.0, reason=reason)
    provenance = asset.provenance.replace(guesses=(*asset.provenance.guesses, guess))
    return asset.replace(contract=None, provenance=provenance)


# Doubts ---------------------------------------------------------------------------------------------------------------
# Find what a person has to decide about an articulated mesh before it counts as accepted: frame, parts, contacts.
#
# An asset in doubt is written as any other and is in review, as `ingest` has it: a warning names what to decide, and
# review.csv of the library lists it.

# What a person decides about an articulated mesh, by the pointer of the warning.
FRAME, PLAN, CONTACTS = "frame", "plan", "contacts"


def doubts(articulation: Articulation, model: ConfidenceModel, contacts: tuple[str, ...] = ()) -> tuple[Issue, ...]:
    """Return a warning for each decision that is too uncertain to be accepted unseen; empty if all are certain enough.

    Args:
        articulation: with calibrated confidences. contacts: sentences on parts that collide or stop too early.
    """
    issues = []
    if articulation.frame.confidence < model.bars.frame:
        issues.append(_issue(FRAME, _frame_message(articulation)))
    if articulation.signs:
        issues.append(_issue(PLAN, f"no moving part was found, but {'; '.join(articulation.signs)}"))
    elif plan_confidence(articulation, model) < model.bars.plan:
        issues.append(_issue(PLAN, _plan_message(articulation, model)))
    if contacts:
        issues.append(_issue(CONTACTS, f"{'; '.join(contacts)}; one of them may be no part, or have another joint"))
    return tuple(issues)


def _issue(subject: str, message: str) -> Issue:
    accept = f"`decision: accept` in {DECISIONS_NAME} accepts it as it is"
    return Issue(code=REVIEW_CODE, severity=Severity.WARNING, pointer=subject, message=f"{message}; {accept}")


def _frame_message(articulation: Articulation) -> str:
    frame = articulation.frame
    up, front = (_direction(frame.direction_to_file(v)) for v in ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
    other = f", else {frame.runner_up}" if frame.runner_up else ""
    return f"front {front} and up {up} are {frame.confidence:.0%} sure{other}; say them with --front and --up"


def _direction(vector: Vec3) -> str:
    """Return a direction for a person to read: the name of an axis, else its three numbers, rounded."""
    word = axis_word(vector)
    return word if isinstance(word, str) else " ".join(f"{v:.2f}" for v in word)


def _plan_message(articulation: Articulation, model: ConfidenceModel) -> str:
    message = f"that all parts are right is {plan_confidence(articulation, model):.0%} sure"
    part = weakest_part(articulation)
    if part is None:
        return message
    other = f", else {part.joint.runner_up}" if part.joint.runner_up else ""
    return f"{message}; least of all {part.name}, {part.confidence:.0%} sure ({part.full_reason}{other})"
