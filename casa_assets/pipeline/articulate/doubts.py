"""Find what a person has to decide about an articulated mesh before it counts as accepted: frame, parts, contacts.

An asset in doubt is written as any other and is in review, as `ingest` has it: a warning names what to decide, and
review.csv of the library lists it.
"""

from __future__ import annotations

from casa_assets.articulate.confidence import plan_confidence, weakest_part
from casa_assets.articulate.decisions import axis_word
from casa_assets.articulate.plan import Articulation
from casa_assets.model.issue import REVIEW_CODE, Issue, Severity
from casa_assets.model.record import Vec3
from casa_assets.model.registry.confidence import ConfidenceModel
from casa_assets.pipeline.articulate.sidecar import NAME

# What a person decides about an articulated mesh, by the pointer of the warning.
FRAME, PLAN, CONTACTS = "frame", "plan", "contacts"


def doubts(articulation: Articulation, model: ConfidenceModel, contacts: tuple[str, ...] = ()) -> tuple[Issue, ...]:
    """Return a warning for each thing that is too uncertain to be accepted unseen; none where all is sure enough.

    Args:
        articulation: with calibrated confidences. contacts: what runs into what, or does not go all its way, in words.
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
    accept = f"`decision: accept` in {NAME} accepts it as it is"
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
