"""Measure a plan: what speaks for each of its parts, and for the plan as a whole."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.kinds import kind_shares, traits_of_parts
from casa_assets.articulate.plan import HingeEdge, PartKind, PartPlan
from casa_assets.articulate.search.plans import Plan
from casa_assets.articulate.segment.orthographic import FRONT, TOP
from casa_assets.articulate.segment.segmentations import Segmentation
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.model.asset.parts import JointKind

# Points on the surface by which parts are tried for room, cells along the diagonal, and shares of the reach tried.
SAMPLES, CELLS, STEPS = 24_000, 110, (0.15, 0.5, 1.0)
# Points of one part that are moved.
MOVED = 300
# A part of another plan is the same from this share of common surface on.
SAME_SURFACE = 0.8
# Parts of one size differ by less, diagonals.
SAME_SIZE = 0.015
FRONTS = (PartKind.DOOR, PartKind.DRAWER)
SMALL = (PartKind.KNOB, PartKind.BUTTON)
EDGES = (HingeEdge.LEFT, HingeEdge.RIGHT, HingeEdge.BOTTOM, HingeEdge.TOP)
_KINDS = tuple(f"is_{kind.value}" for kind in PartKind)
_EDGES = tuple(f"at_{edge.value}" for edge in EDGES)
_WAYS = tuple(f"by_{way.name.lower()}" for way in Segmentation)
PART_FEATURES = (
    *_KINDS,
    *_EDGES,
    *_WAYS,
    "slides",
    "sure",
    "sure_of_joint",
    "width",
    "depth",
    "height",
    "across",
    "up",
    "behind",
    "log_ratio",
    "slimness",
    "longest",
    "visible",
    "fill",
    "grip",
    "grips_area",
    "nested",
    "bears",
    "alike",
    "of_its_kind",
    "count",
    "blocked",
    "blocked_at_once",
    "agreed_in_frame",
    "frame",
    "frame_rank",
    "kind_share",
    "assumes_kind",
    "is_shell",
    "share_of_area",
    "overlap",
)
PLAN_FEATURES = (
    *_WAYS,
    "frame",
    "frame_rank",
    "kind_share",
    "assumes_kind",
    "is_shell",
    "count",
    *(f"count_{kind.value}" for kind in PartKind),
    "mean",
    "weakest",
    "all_right",
    "expected",
    "surplus",
    "fronts_cover",
    "top_cover",
    "spare_panels",
    "spare_controls",
    "with_handle",
    "nested",
    "blocked",
    "worst_blocked",
    "agreed_in_frame",
    "best_kind",
    "kind_margin",
    "sizes",
    "none_found",
    "moving_area",
    "overlap",
    "behind_surplus",
)


@dataclass(frozen=True)
class PlanMeasures:
    """Measures of a plan and of its parts.

    Attributes:
        parts: (P, len(PART_FEATURES)). whole: values of PLAN_FEATURES but those that need the probabilities of parts.
    """

    parts: Floats
    whole: Mapping[str, float]


def measure_plans(plans: Sequence[Plan]) -> list[PlanMeasures]:
    """Measure plans of one mesh, each also by how far the others in its frame agree with it."""
    if not plans:
        return []
    mesh = plans[0].measured.mesh
    owners = [p.articulation.face_owner(len(mesh.faces)) for p in plans]
    agreement = [_agreements(plans, owners, mesh.areas, k) for k in range(len(plans))]
    frames = list(dict.fromkeys(id(p.frame) for p in plans))
    samples: dict[int, tuple[Floats, Ints]] = {}
    out = []
    for k, plan in enumerate(plans):
        place = id(plan.measured.mesh)
        if place not in samples:
            samples[place] = samples_with_faces(plan.measured.mesh.points, plan.measured.mesh.faces, SAMPLES)
        rank = frames.index(id(plan.frame))
        out.append(_measure(plan, owners[k], agreement[k], samples[place], rank))
    return out


def _agreements(plans: Sequence[Plan], owners: Sequence[Ints], areas: Floats, one: int) -> Floats:
    """Return for each part of a plan the share of the ways in its frame that have such a part."""
    parts = plans[one].articulation.parts
    agrees: dict[Segmentation, Floats] = {}
    own = np.bincount(owners[one] + 1, areas, len(parts) + 1)[1:]
    for k, other in enumerate(plans):
        if other.frame is not plans[one].frame:
            continue
        held = agrees.setdefault(other.way, np.zeros(len(parts)))
        theirs = other.articulation.parts
        if not theirs:
            continue
        pairs = (owners[one] + 1) * (len(theirs) + 1) + owners[k] + 1
        both = np.bincount(pairs, areas, (len(parts) + 1) * (len(theirs) + 1))
        both = both.reshape(len(parts) + 1, len(theirs) + 1)[1:, 1:]
        other_area = np.bincount(owners[k] + 1, areas, len(theirs) + 1)[1:]
        iou = both / np.maximum(own[:, None] + other_area[None] - both, 1e-15)
        same = [[a.kind is b.kind and a.joint.kind is b.joint.kind for b in theirs] for a in parts]
        found = (iou >= SAME_SURFACE) & np.array(same, dtype=bool).reshape(iou.shape)
        held[:] = np.maximum(held, found.any(axis=1))
    return np.asarray(np.mean(list(agrees.values()), axis=0))


def _measure(plan: Plan, owner: Ints, agreement: Floats, samples: tuple[Floats, Ints], rank: int) -> PlanMeasures:
    measured, found = plan.measured, plan.articulation
    mesh, parts = measured.mesh, found.parts
    corners = mesh.points[mesh.faces]
    whole_lower, whole_upper = mesh.points.min(axis=0), mesh.points.max(axis=0)
    extent = np.maximum(whole_upper - whole_lower, 1e-9)
    boxes = [(corners[p.faces].min(axis=(0, 1)), corners[p.faces].max(axis=(0, 1))) for p in parts]
    sizes = np.array([b - a for a, b in boxes]).reshape(-1, 3)
    seen = measured.depth_images[FRONT].face
    seen_by = np.bincount(np.where(seen >= 0, owner[seen] + 1, 0).reshape(-1), minlength=len(parts) + 1)[1:]
    pixels = max(int((seen >= 0).sum()), 1)
    pixel = measured.depth_images[FRONT].pixel
    top = measured.depth_images[TOP].face
    top_by = np.bincount(np.where(top >= 0, owner[top] + 1, 0).reshape(-1), minlength=len(parts) + 1)[1:]
    bears = np.zeros(len(parts))
    names = {p.name: i for i, p in enumerate(parts)}
    for part in parts:
        if part.parent in names:
            bears[names[part.parent]] += 1
    total = max(float(mesh.areas.sum()), 1e-12)
    is_shell = float(plan.fragmentation.shell is not None)
    blocked = [_blocked(plan, i, owner, samples) for i in range(len(parts))]
    overlap = _overlaps(parts, boxes)
    rows = np.zeros((len(parts), len(PART_FEATURES)))
    share, assumes = plan.hypothesis.share, float(bool(plan.hypothesis.kind))
    for i, part in enumerate(parts):
        (a, b), size = boxes[i], np.maximum(sizes[i], 1e-9)
        alike = (np.abs(sizes - size).max(axis=1) < SAME_SIZE) & np.array([p.kind is part.kind for p in parts])
        row = {
            f"is_{part.kind.value}": 1.0,
            f"by_{plan.way.name.lower()}": 1.0,
            "slides": float(part.joint.kind is JointKind.SLIDE),
            "sure": part.confidence,
            "sure_of_joint": part.joint.confidence,
            "width": size[0] / extent[0],
            "depth": size[1] / extent[1],
            "height": size[2] / extent[2],
            "across": ((a + b)[0] / 2 - whole_lower[0]) / extent[0],
            "up": ((a + b)[2] / 2 - whole_lower[2]) / extent[2],
            "behind": (a[1] - whole_lower[1]) / extent[1],
            "log_ratio": math.log(size[0] / size[2]),
            "slimness": min(size[0], size[2]) / max(size[0], size[2]),
            "longest": float(size.max()),
            "visible": seen_by[i] / pixels,
            "fill": seen_by[i] * pixel**2 / (size[0] * size[2]),
            "grip": float(len(part.grip) > 0),
            "grips_area": float(mesh.areas[part.grip].sum() / max(float(mesh.areas[part.faces].sum()), 1e-12)),
            "nested": float(bool(part.parent)),
            "bears": bears[i],
            "alike": math.log1p(int(alike.sum())),
            "of_its_kind": math.log1p(sum(p.kind is part.kind for p in parts)),
            "count": math.log1p(len(parts)),
            "blocked": blocked[i][0],
            "blocked_at_once": blocked[i][1],
            "agreed_in_frame": agreement[i],
            "frame": plan.frame.confidence,
            "frame_rank": float(rank),
            "kind_share": share,
            "assumes_kind": assumes,
            "is_shell": is_shell,
            "share_of_area": float(mesh.areas[part.faces].sum()) / total,
            "overlap": overlap[i],
        }
        if part.joint.edge is not None:
            row[f"at_{part.joint.edge.value}"] = 1.0
        rows[i] = [row.get(name, 0.0) for name in PART_FEATURES]
    x, y, z = (float(v) for v in extent)
    shares = sorted(kind_shares((x, y, z), traits_of_parts(found)).values(), reverse=True)
    fronts = [i for i, p in enumerate(parts) if p.kind in FRONTS]
    least = [min(p.confidence, p.joint.confidence) for p in parts]
    behind = sum(seen_by[i] for i in fronts) / pixels
    whole = {
        f"by_{plan.way.name.lower()}": 1.0,
        "frame": plan.frame.confidence,
        "frame_rank": float(rank),
        "kind_share": share,
        "assumes_kind": assumes,
        "is_shell": is_shell,
        "count": math.log1p(len(parts)),
        **{f"count_{k.value}": math.log1p(sum(p.kind is k for p in parts)) for k in PartKind},
        "fronts_cover": behind,
        "top_cover": float(top_by.sum()) / max(int((top >= 0).sum()), 1),
        "spare_panels": plan.hypothesis.spare_panels,
        "spare_controls": math.log1p(plan.hypothesis.spare_controls),
        "with_handle": sum(len(parts[i].grip) > 0 for i in fronts) / max(len(fronts), 1),
        "nested": math.log1p(sum(bool(p.parent) for p in parts)),
        "blocked": float(np.mean([b[0] for b in blocked])) if blocked else 0.0,
        "worst_blocked": max((b[0] for b in blocked), default=0.0),
        "agreed_in_frame": float(np.mean(agreement)) if parts else 0.0,
        "best_kind": shares[0],
        "kind_margin": shares[0] - shares[1],
        "sizes": _distinct_sizes(sizes[fronts]) / max(len(fronts), 1),
        "none_found": float(not parts),
        "moving_area": float(mesh.areas[owner >= 0].sum()) / total,
        "overlap": float(max(overlap, default=0.0)),
        "behind_surplus": sum(least) - 0.3 * len(least),
    }
    return PlanMeasures(rows, whole)


def _distinct_sizes(sizes: Floats) -> int:
    """Return how many different sizes there are, across and up."""
    kept: list[Floats] = []
    for size in sizes:
        if not any(float(np.abs(size - other)[[0, 2]].max()) < SAME_SIZE for other in kept):
            kept.append(size)
    return len(kept)


def _overlaps(parts: Sequence[PartPlan], boxes: Sequence[tuple[Floats, Floats]]) -> list[float]:
    """Return for each front the largest share of its rectangle that another front covers too."""
    out = []
    for i, part in enumerate(parts):
        most = 0.0
        if part.kind in FRONTS and not part.parent:
            (a, b) = boxes[i]
            for j, other in enumerate(parts):
                if j == i or other.kind not in FRONTS or other.parent:
                    continue
                c, d = boxes[j]
                common = np.maximum(np.minimum(b, d) - np.maximum(a, c), 0.0)
                most = max(most, float(common[0] * common[2]) / max(float((b - a)[0] * (b - a)[2]), 1e-12))
        out.append(most)
    return out


def _blocked(plan: Plan, index: int, owner: Ints, samples: tuple[Floats, Ints]) -> tuple[float, float]:
    """Return the largest share of a part's points that run into the rest on its way, and that at the first step."""
    points, face = samples
    part = plan.articulation.parts[index]
    carried = {part.name}
    for other in plan.articulation.parts:
        if other.parent in carried:
            carried.add(other.name)
    mine = np.isin(owner[face], [i for i, p in enumerate(plan.articulation.parts) if p.name in carried])
    if not mine.any() or mine.all() or part.joint.endless:
        return 0.0, 0.0
    own = points[mine]
    own = own[:: max(1, len(own) // MOVED)]
    rest = np.unique(_cells(points[~mine]))
    # Where the part lies at rest, others may lie next to it: a cell that both fill is no wall.
    around = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3), axis=-1).reshape(-1, 3) / CELLS
    shared = np.unique(_cells((points[mine][:, None] + around).reshape(-1, 3)))
    walls = rest[~np.isin(rest, shared, assume_unique=True)]
    shares = []
    for step in STEPS:
        amount = part.joint.range[0] + step * (part.joint.range[1] - part.joint.range[0])
        shares.append(float(np.isin(_cells(_moved(own, part, amount)), walls).mean()))
    return max(shares), shares[0]


def _cells(points: Floats) -> Ints:
    cell = np.floor((points + 2.0) * CELLS).astype(np.int64)
    return np.asarray((cell[:, 0] * 4096 + cell[:, 1]) * 4096 + cell[:, 2])


def _moved(points: Floats, part: PartPlan, amount: float) -> Floats:
    axis, anchor = np.array(part.joint.axis), np.array(part.joint.anchor)
    if part.joint.kind is JointKind.SLIDE:
        slid: Floats = points + axis * amount
        return slid
    away = points - anchor
    cos, sin = math.cos(amount), math.sin(amount)
    turned: Floats = anchor + away * cos + np.cross(axis, away) * sin + np.outer(away @ axis, axis) * (1 - cos)
    return turned


def whole_features(measures: PlanMeasures, chances: Floats) -> Floats:
    """Return the (len(PLAN_FEATURES),) features of a plan.

    Args:
        chances: (P,) probability that each part is right.
    """
    given = chances if len(chances) else np.zeros(1)
    values = {
        **measures.whole,
        "mean": float(given.mean()),
        "weakest": float(given.min()),
        "all_right": float(np.prod(given)),
        "expected": math.log1p(float(given.sum())),
        "surplus": float((chances - 0.5).sum()) if len(chances) else 0.0,
    }
    row: Floats = np.array([values.get(name, 0.0) for name in PLAN_FEATURES])
    return row
