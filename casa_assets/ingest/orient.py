"""Orient a mesh: choose up and front by the file's word, the usual shape of the category, capacity and balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from casa_assets.core.numeric import Floats
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.pose.front import Facing, facing, straightened
from casa_assets.ingest.pose.up import (
    UP_ROTATIONS,
    SurfaceSample,
    balance_score,
    candidates,
    doubts,
    origin_evidence,
    pose_score,
    priors,
    sample_surface,
    stance,
)
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill, RestingPose
from casa_assets.model.source import NO_OVERRIDE, UserOverride

# Smallest confidence in a pose if the category rests in any pose.
MIN_CONFIDENCE_ANY_POSE = 0.9
# How many times more probable than the axis that the file states another way up has to be, beyond what the prior of the
# stated axis says; a choice.
OVERRULE_ODDS = 1.5
# Cosine of the angle (15 degrees) up to which two ways up are one; which of them is taken is the file's word, unless
# another one is so many times as probable by itself; choices.
SAME_COSINE, TILT_ODDS = 0.966, 3.0
# Candidates whose score without rain is so far behind the best one are dropped, nats; rain decides for vessels.
HOPELESS_NATS, HOPELESS_NATS_VESSEL = 8.0, 16.0


def orient(
    draft: Draft,
    category: Category,
    generated: bool = False,
    override: UserOverride = NO_OVERRIDE,
    failed_ups: Sequence[str] = (),
) -> Draft:
    """Turn the parts, in file axes, so that z is up and the front points where the category has it.

    `generated`: from a text-to-3D generator; these write y up whatever the format. `override`: `up` and `turn_deg`
    count here. `failed_ups`: ways up, named as in guesses, in which the object was built and fell over or did not fit.
    """
    try:
        cloud = sample_surface(draft.surface.vertices, draft.surface.faces)
    except DegenerateShape as error:
        raise Rejected("MSH002", "all faces lie in one plane or on one line; a thing needs a thickness") from error
    declared = "dae" if draft.format == "dae" and draft.up in ("y", "z") else "declared"
    prior_key = f"{declared}_{draft.up}" if draft.up else ("generated" if generated else draft.format)
    stated = f"the file states {draft.up} up" if draft.up else f"{draft.format} states no up axis"
    if override.up is not None:
        name, rotation, confidence = override.up.value, UP_ROTATIONS[override.up.value], 1.0
        reason = "a person decided"
    else:
        points = draft.surface.vertices
        name, rotation, confidence = _best_candidate(points, cloud, category, prior_key, draft.up, failed_ups)
        reason = f"{stated}; weighed with the usual shape, room and balance of a {category.id}"
        if category.upright is RestingPose.ANY and category.id != FALLBACK:
            confidence = max(confidence, MIN_CONFIDENCE_ANY_POSE)
            reason = f"{stated}; a {category.id} rests in any pose"
        if category.id == FALLBACK:
            reason = f"{stated}; weighed with its room and foot, since nobody knows what it is"
        if failed_ups:
            reason += f"; with {' and '.join(failed_ups)} up it failed"
    front = _front(cloud.samples @ rotation.T, category, draft, name, override)
    rotation = _about_z(front.angle) @ rotation
    parts = []
    for part in draft.parts:
        normals = None if part.mesh.normals is None else part.mesh.normals @ rotation.T
        parts.append(part.replace(mesh=part.mesh.with_vertices(part.mesh.vertices @ rotation.T, normals)))
    out = draft.replace(parts=tuple(parts), up="z")
    out = out.replace(guesses=out.guessed("up_axis", _up_in_words(name, rotation), confidence, reason))
    return out.replace(guesses=out.guessed("front", front.value, front.confidence, front.reason))


def _up_in_words(name: str, rotation: Floats) -> str:
    """A way up for a guess: the axis, or a direction in the axes of the file if it is not along an axis."""
    return name if name in UP_ROTATIONS else " ".join(f"{v:.3f}" for v in rotation[2])


def _best_candidate(
    points: Floats,
    cloud: SurfaceSample,
    category: Category,
    prior_key: str,
    stated_up: str | None,
    failed_ups: Sequence[str],
) -> tuple[str, Floats, float]:
    """Name, rotation and confidence, 0..1, of the best candidate: the stated one unless another is far likelier."""
    options = [one for one in candidates(cloud) if _up_in_words(*one) not in failed_ups]
    names, rotations = [name for name, _ in options], [rotation for _, rotation in options]
    prior = priors(prior_key, names) + origin_evidence(points, names)

    log = prior + np.array([pose_score(stance(cloud, r, with_rain=False), category) for r in rotations])
    if category.upright is not RestingPose.ANY or category.id == FALLBACK:
        margin = HOPELESS_NATS_VESSEL if category.build is MatterFill.VESSEL else HOPELESS_NATS
        kept = np.flatnonzero(log > log.max() - margin)
        stances = [stance(cloud, rotations[k], with_rain=True) for k in kept]
        log = np.full(len(options), -np.inf)
        log[kept] = prior[kept] + np.array([pose_score(s, category) for s in stances]) / doubts(stances, category)
        log[kept] += [balance_score(s, category) for s in stances]
    share = np.exp(log - log.max())
    share /= share.sum()
    # A slight tilt leaves no doubt about the resting pose; a banana rests equally well on either side.
    ups = np.array([rotation[2] for rotation in rotations])
    lies_on_either_side = category.upright is RestingPose.LIES and category.build is MatterFill.SOLID
    is_same = (np.abs(ups @ ups.T) if lies_on_either_side else ups @ ups.T) > SAME_COSINE
    together = is_same @ share
    group = is_same[int(np.argmax(together))]
    best = int(np.argmax(np.where(group, share, -1.0)))
    stated = next((k for k, name in enumerate(names) if name == stated_up), best)
    if is_same[best, stated]:
        best = best if share[best] > TILT_ODDS * share[stated] else stated
    elif together[best] <= OVERRULE_ODDS * together[stated]:
        # Between these two alone: a third way up is no reason to doubt the file.
        return names[stated], rotations[stated], float(together[stated] / (together[stated] + together[best]))
    return names[best], rotations[best], float(min(together[best], 1.0))


def _front(samples: Floats, category: Category, draft: Draft, name: str, override: UserOverride) -> Facing:
    """The turn to the front of (N, 3) samples in the chosen pose; else a pose off the axes is straightened."""
    if override.turn_deg is not None:
        turned = f"turned by {override.turn_deg:g} degrees"
        return Facing(float(np.radians(override.turn_deg)), turned, 1.0, "a person decided")
    front = facing(samples, category, draft.up is not None and draft.format in ("glb", "gltf"))
    if front.angle == 0 and name not in UP_ROTATIONS:
        return replace(front, angle=straightened(samples))
    return front


def _about_z(angle: float) -> Floats:
    """(3, 3) turn about z; quarter turns are exact."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    quarters = angle / (np.pi / 2)
    if abs(quarters - round(quarters)) < 1e-9:
        c, s = float(round(c)), float(round(s))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]], dtype=np.float64)
