"""Orient a mesh: choose up and front by the file's word, the usual shape of the category, capacity and balance."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.pose.cloud import SurfaceSample, sample_surface
from casa_assets.ingest.pose.evidence import pose_score, stance
from casa_assets.ingest.pose.front import Facing, facing, straightened
from casa_assets.ingest.pose.ups import UP_ROTATIONS, candidates, priors
from casa_assets.model.ingest.source import RawPart
from casa_assets.model.ingest.user_override import NO_OVERRIDE, UserOverride
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# How sure one can be of a pose at most where nobody knows what the thing is.
MAX_CONFIDENCE_UNKNOWN = 0.45
# How sure one is that the pose will do where the category has none.
CONFIDENCE_WITHOUT_POSE = 0.9
# Candidates that are so far behind the best one before it rains are not looked at further, nats; for vessels the rain
# decides.
HOPELESS_NATS, HOPELESS_NATS_VESSEL = 8.0, 16.0


def orient(draft: Draft, category: Category, generated: bool = False, override: UserOverride = NO_OVERRIDE) -> Draft:
    """Turn the parts so that z is up and the front points where the category has it.

    Args:
        draft: in file axes.
        category: its usual shape and way of resting are the evidence.
        generated: from a text-to-3D generator, which write y up whatever the format.
        override: what a person decided; `up` and `turn_deg` count here.
    """
    try:
        cloud = sample_surface(draft.surface.vertices, draft.surface.faces)
    except DegenerateShape as error:
        raise Rejected("MSH002", "all faces lie in one plane or on one line; a thing needs a thickness") from error
    stater = "dae" if draft.format == "dae" and draft.up in ("y", "z") else "declared"
    key = f"{stater}_{draft.up}" if draft.up else ("generated" if generated else draft.format)
    stated = f"the file states {draft.up} up" if draft.up else f"{draft.format} states no up axis"
    if override.up is not None:
        name, turn, confidence, reason = override.up.value, UP_ROTATIONS[override.up.value], 1.0, "a person decided"
    else:
        name, turn, confidence = _best(cloud, category, key)
        reason = f"{stated}; weighed with the usual shape, room and balance of a {category.id}"
        if category.upright is RestingPose.ANY:
            confidence, reason = (
                max(confidence, CONFIDENCE_WITHOUT_POSE),
                f"{stated}; a {category.id} rests in any pose",
            )
        if category.id == "object":
            confidence, reason = (
                min(confidence, MAX_CONFIDENCE_UNKNOWN),
                f"{stated}; nobody knows what it is and how it rests",
            )
    look = _look(cloud.samples @ turn.T, category, draft, name, override)
    turn = _about_z(look.angle) @ turn
    out = draft.replace(parts=tuple(_turned(p, turn) for p in draft.parts), up="z")
    out = out.replace(guesses=out.guessed("up_axis", name, confidence, reason))
    return out.replace(guesses=out.guessed("front", look.value, look.confidence, look.reason))


def _best(cloud: SurfaceSample, category: Category, key: str) -> tuple[str, Floats, float]:
    """Name and rotation of the best candidate, and how sure one can be of it."""
    ways = candidates(cloud)
    log = priors(key, [name for name, _ in ways])
    if category.upright is RestingPose.ANY or category.id == "object":
        log = np.array([p + pose_score(stance(cloud, t, False), category) for p, (_, t) in zip(log, ways, strict=True)])
    else:
        quick = np.array(
            [p + pose_score(stance(cloud, t, False), category) for p, (_, t) in zip(log, ways, strict=True)]
        )
        hopeful = quick > quick.max() - (HOPELESS_NATS_VESSEL if category.build is MatterFill.VESSEL else HOPELESS_NATS)
        log = np.array(
            [
                p + pose_score(stance(cloud, turn, True), category) if hope else -np.inf
                for p, (_, turn), hope in zip(log, ways, hopeful, strict=True)
            ]
        )
    best = int(np.argmax(log))
    return ways[best][0], ways[best][1], float(1 / np.exp(log - log[best]).sum())


def _look(samples: Floats, category: Category, draft: Draft, name: str, override: UserOverride) -> Facing:
    if override.turn_deg is not None:
        return Facing(
            float(np.radians(override.turn_deg)), f"turned by {override.turn_deg:g} degrees", 1.0, "a person decided"
        )
    look = facing(samples, category, draft.up is not None and draft.format in ("glb", "gltf"))
    if look.angle == 0 and name not in UP_ROTATIONS:
        return Facing(straightened(samples), look.value, look.confidence, look.reason)
    return look


def _about_z(angle: float) -> Floats:
    """(3, 3) turn about z; quarter turns are exact."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    quarters = angle / (np.pi / 2)
    if abs(quarters - round(quarters)) < 1e-9:
        c, s = float(round(c)), float(round(s))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]], dtype=np.float64)


def _turned(part: RawPart, turn: Floats) -> RawPart:
    mesh = part.mesh
    normals = None if mesh.normals is None else mesh.normals @ turn.T
    return part.replace(mesh=mesh.with_vertices(mesh.vertices @ turn.T, normals))
