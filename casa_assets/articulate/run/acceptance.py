"""Accept a built asset: limit ranges of joints, mend what checks find, test its contract, list open decisions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from casa_assets import registry
from casa_assets.articulate.assemble import ROOT
from casa_assets.articulate.decisions import DECISIONS_NAME, axis_word, hinge_at_face
from casa_assets.articulate.plan import Articulation, plan_confidence
from casa_assets.articulate.run.build import ArticulateResult
from casa_assets.checks.check import Package, run
from casa_assets.checks.motion.joints import JointTravel, joint_travels
from casa_assets.checks.motion.simulation import Penetration, contacts_of_files
from casa_assets.checks.table import TABLE
from casa_assets.errors import Rejected
from casa_assets.formats import mjcf
from casa_assets.model.asset.asset import Asset, Exclusion, Guess
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.issue import REVIEW_CODE, Issue, Report, Severity
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.contract import Contract
from casa_assets.model.registry.rows import ConfidenceModel

# A part that moves through less than this share of its range before it meets something has a wrong joint, or shapes
# that are too coarse to tell: its range stays.
MIN_FREE_TRAVEL = 0.25
# A hinge is moved to the face of its door where that frees so much more of the range.
MIN_TRAVEL_GAIN = 0.05
# Checks of collision shapes that shapes fitted again may pass: their box, where mass lies, and what they cover.
SHAPE_CODES = frozenset({"AST008", "AST009", "AST016"})
# The check of parts that run into each other, and its limit in registry/limits.yaml.
CONTACT_CODE, CONTACT_LIMIT = "MJC009", "sweep_penetration_m"
# Angles to which a door is opened so that what is behind it gets out. Choices: hinges of cabinets go that far.
WIDER_RAD = (math.radians(110.0), math.radians(135.0), math.radians(150.0))
# Pairs of parts that are looked for one after another; of each joint only the deepest contact is known at a time.
MAX_ROUNDS = 6
# An asset names a contract only where every check of it passes: names and paths, poses and states as MuJoCo operates
# them, and what a hand has to be able to move. Otherwise the failed checks are reported.
# What is there and how it is called; looked at first, for it costs nothing.
NAME_CODES = ("CON", "BEH001", "BEH002")
# How it moves and what it holds: rows that look at nothing but what a runtime operates.
MOTION_CODES = ("BEH003", "KIN", "HOL", "AST017")
# Of the faults that are kept with the asset.
MAX_LISTED_FAULTS = 6
# An asset in doubt is written as any other and is in review, as `ingest` has it: a warning names what to decide, and
# review.csv of the library lists it.
# What a person decides about an articulated mesh, by the pointer of the warning.
FRAME, PLAN, CONTACTS = "frame", "plan", "contacts"


def limit_ranges(built: ArticulateResult) -> ArticulateResult:
    """Return the asset with each joint limited to the range before its part meets something.

    A door that is stuck in its frame first gets its axis at its face, where that frees it.
    """
    travel = _free_travel(built)
    stuck = {
        part.name: hinge_at_face(part, built.placed)
        for part in built.articulation.parts
        if travel[part.name].free_share < MIN_FREE_TRAVEL and part.joint.edge
    }
    if stuck:
        moved = built.with_joints(stuck)
        freed = _free_travel(moved)
        helped = {n: j for n, j in stuck.items() if freed[n].free_share > travel[n].free_share + MIN_TRAVEL_GAIN}
        if len(helped) == len(stuck):
            built, travel = moved, freed
        elif helped:
            built = built.with_joints(helped)
            travel = _free_travel(built)
    limited, is_behind = _limited(built, travel)
    # What lies behind a door that now opens less far has less room than was measured.
    return _limited(limited, _free_travel(limited))[0] if is_behind else limited


def _limited(built: ArticulateResult, travel: Mapping[str, JointTravel]) -> tuple[ArticulateResult, bool]:
    """Return the asset with joints limited to the range that is free, and whether something lies behind one of them."""
    metres = built.articulation.frame.metres or 1.0
    limited = {}
    for part in built.articulation.parts:
        free, joint = travel[part.name].free_share, part.joint
        if MIN_FREE_TRAVEL <= free < 1.0 and not joint.endless:
            end = joint.range[1] * free
            # Rounded down to what decisions.yaml can express: tenths of a degree, or of a millimetre.
            if joint.kind is JointKind.HINGE:
                end = math.radians(math.floor(math.degrees(end) * 10) / 10)
            else:
                end = math.floor(end * metres * 1e4) / 1e4 / metres
            reason = f"{joint.reason}; then it runs into {travel[part.name].blocked_by}"
            limited[part.name] = joint.replace(range=(0.0, end), reason=reason)
    names = {joint.name for joint in built.asset.joints if joint.child in limited}
    return built.with_joints(limited), any(joint.behind in names for joint in built.asset.joints)


def _free_travel(built: ArticulateResult) -> Mapping[str, JointTravel]:
    """Return how far each part moves before it meets something, by its name. Raises Rejected."""
    try:
        found = joint_travels(built.asset, mjcf.write(built.asset), pushed=False)
    except ValueError as error:
        raise Rejected("MJC001", f"MuJoCo cannot read the model: {error}") from error
    return {j.child: t for j, t in zip(built.asset.joints, found, strict=True)}


def mend(built: ArticulateResult, named: ArticulateResult, report: Report) -> ArticulateResult | None:
    """Return the asset with errors of its checks repaired, or None if none of them can be repaired.

    Args:
        built: under the names of its parts. named: the same under the names that runtimes look for, as it was checked.
    """
    child = {joint.name: joint.child for joint in named.asset.joints}
    part_of = {child[joint]: part for part, joint in named.joints.items()}
    links = [issue.pointer.split("/")[1] for issue in report.errors if issue.code in SHAPE_CODES]
    refit = {part_of.get(link, ROOT) for link in links} - built.spec.refit
    mended = built.with_refit_shapes(refit) if refit else built
    if any(issue.code == CONTACT_CODE for issue in report.errors):
        mended = _without_contacts(_with_doors_wider(mended))
    return None if mended is built else mended


def _with_doors_wider(built: ArticulateResult) -> ArticulateResult:
    """Return the asset with doors opened wider where what moves behind them runs into them."""
    joints = {joint.name: joint for joint in built.asset.joints}
    for name, (contact, _) in _contacts(built.asset).items():
        door = joints.get(joints[name].behind or "")
        if door is None or door.kind is not JointKind.HINGE or door.child not in (contact.body1, contact.body2):
            continue
        plan = next(p.joint for p in built.articulation.parts if p.name == door.child)
        for angle in WIDER_RAD:
            reason = f"{plan.reason}; opened so far that {joints[name].child} gets out"
            wider = built.with_joints({door.child: plan.replace(range=(0.0, angle), reason=reason)})
            is_free = {t.joint: t.free_share for t in joint_travels(wider.asset, mjcf.write(wider.asset), pushed=False)}
            still = _contacts(wider.asset).get(name)
            if is_free[door.name] >= 1.0 and (still is None or door.child not in (still[0].body1, still[0].body2)):
                built = wider
                break
    return built


def _without_contacts(built: ArticulateResult) -> ArticulateResult:
    """Return the asset with contact disabled between parts that collide, and with sentences for a person to review.

    Shapes that overlap with all joints closed are coarser than the visible geometry. If a part runs into another one on
    its way, its joint or its kind may be wrong, or the shapes may be too coarse to decide: a person has to look.
    """
    asset, words = built.asset, list(built.contacts)
    for _ in range(MAX_ROUNDS):
        found = _contacts(asset)
        if not found:
            break
        pairs: dict[tuple[str, str], None] = {}
        for name, (contact, at_rest) in found.items():
            first, second = contact.body1, contact.body2
            pairs[first, second] = None
            moving = next(joint.child for joint in asset.joints if joint.name == name)
            if contact.depth > at_rest + registry.load().limits[CONTACT_LIMIT]:
                words.append(f"{moving} runs into {second if moving == first else first} on its way")
        exclusions = tuple(Exclusion(first=first, second=second) for first, second in pairs)
        asset = asset.replace(exclusions=(*asset.exclusions, *exclusions))
    return replace(built, asset=asset, contacts=tuple(dict.fromkeys(words)))


def _contacts(asset: Asset) -> Mapping[str, tuple[Penetration, float]]:
    """Return the deepest contact of each joint that penetrates another part deeper than the limit, by joint name.

    The second value is how deep the two parts penetrate each other with all joints closed, in metres.
    """
    limit = registry.load().limits[CONTACT_LIMIT]
    return {name: row for name, row in contacts_of_files(mjcf.write(asset)).items() if row[0].depth > limit}


def unmet_checks(
    asset: Asset, category: Category, root: Path, contract: Contract | None, limits: Mapping[str, float]
) -> tuple[str, ...]:
    """Return the failed checks of the contract that an asset names; empty where it meets it."""
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


def doubts(articulation: Articulation, model: ConfidenceModel, contacts: tuple[str, ...] = ()) -> tuple[Issue, ...]:
    """Return a warning for each decision that is too uncertain to be accepted unseen; empty if all are certain enough.

    Args:
        articulation: with calibrated confidences. contacts: sentences on parts that collide or stop too early.
    """
    messages = {}
    frame, sure = articulation.frame, plan_confidence(articulation, model)
    if frame.confidence < model.bars.frame:
        words = [axis_word(frame.direction_to_file(v)) for v in ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0))]
        front, up = (word if isinstance(word, str) else " ".join(f"{v:.2f}" for v in word) for word in words)
        other = f", else {frame.runner_up}" if frame.runner_up else ""
        certain = f"{frame.confidence:.0%} sure{other}"
        messages[FRAME] = f"front {front} and up {up} are {certain}; say them with --front and --up"
    if articulation.signs:
        messages[PLAN] = f"no moving part was found, but {'; '.join(articulation.signs)}"
    elif sure < model.bars.plan:
        messages[PLAN] = f"that all parts are right is {sure:.0%} sure"
        part = min((p for p in articulation.parts if not p.added), key=lambda p: p.confidence, default=None)
        if part is not None:
            other = f", else {part.joint.runner_up}" if part.joint.runner_up else ""
            messages[PLAN] += f"; least of all {part.name}, {part.confidence:.0%} sure ({part.full_reason}{other})"
    if contacts:
        messages[CONTACTS] = f"{'; '.join(contacts)}; one of them may be no part, or have another joint"
    accept = f"`decision: accept` in {DECISIONS_NAME} accepts it as it is"
    return tuple(
        Issue(code=REVIEW_CODE, severity=Severity.WARNING, pointer=subject, message=f"{message}; {accept}")
        for subject, message in messages.items()
    )
