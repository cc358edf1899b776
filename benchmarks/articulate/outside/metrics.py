"""Score predicted moving parts against the truth of a case: parts by their surface, joints by type, axis and place.

A part is found (F1) where it shares at least half of its surface with a part of the truth (IoU, one to one). MAO counts
those whose joint type is right too, whose axis is within 5 degrees, and whose hinge is within a tenth of the diagonal
of the part. A case is right where nothing is missed or made up and every part opens the right way; mostly right with
one fault, or one in four. E is the joint metric of ArticulateArena (arXiv 2609.33931): a distance between two joints
from where their ends take them, lengths in diagonals of the object; parts that are missed or made up count as fixed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from articulatearena import compactified_joint_metric, make_split_norm, screw_twist
from scipy.optimize import linear_sum_assignment

from benchmarks.articulate.labelled import read_obj
from benchmarks.articulate.outside.cases import read_truth
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.surface import face_normals

Row = Mapping[str, Any]
MIN_IOU, MAX_AXIS_DEG, MAX_ORIGIN = 0.5, 5.0, 0.1
# Names of one type of part.
SAME_TYPE = {"lid": "door", "spout": "lever"}
# Parts whose direction of opening is given by their closed pose; a knob turns either way.
DIRECTED = ("door", "drawer", "lid", "tray", "button")
# A case is mostly right with this share of faults.
MOST_FAULTS = 0.25
# Scale of the compactification of E, by which long reaches count less. A choice: one turn.
KAPPA = 2 * math.pi


@dataclass(frozen=True)
class CaseScore:
    """How a prediction of one case compares with its truth.

    Attributes:
        truth, predicted: number of moving parts that count. parts: a row of each of the truth. extra: names of
            predicted parts that are none of the truth. distances: E of each pair, and of what has no partner.
    """

    name: str
    kind: str
    truth: int
    predicted: int
    parts: tuple[dict[str, Any], ...]
    extra: tuple[str, ...]
    distances: tuple[float, ...] = field(default=())

    @property
    def faults(self) -> int:
        """Number of parts that are missed, made up, or wrong in type of joint, axis, place or direction."""
        return len(self.extra) + sum(not p["right"] for p in self.parts)

    @property
    def is_perfect(self) -> bool:
        """True if there is no fault."""
        return self.faults == 0

    @property
    def is_mostly_right(self) -> bool:
        """True if there is at most one fault beside a part that is right, or one in four."""
        count = max(self.truth, self.predicted)
        return self.faults <= max(1, MOST_FAULTS * count) and self.faults < count


def score_case(folder: Path, variant: str, prediction: Row) -> CaseScore:
    """Score a prediction on a variant of a case.

    Args:
        prediction: `parts`, each with `faces` or `face_runs` of VARIANT.obj in the order of the file, `type` and
            `joint` (`type`, `axis`, `origin`, `range`), in the axes and units of the file.
    """
    truth = read_truth(folder)
    points, faces = read_obj(folder / f"{variant}.obj")
    return compare(truth, points, faces, face_labels(truth, variant, len(faces)), prediction)


def face_labels(truth: Row, variant: str, count: int) -> Ints:
    """Return the (F,) id of the part of each face of a variant, 0 for the body."""
    label = np.zeros(count, dtype=np.int64)
    for part in truth["parts"]:
        runs = truth["fused"]["parts"][str(part["id"])] if variant == "fused" else part["faces"]
        for start, length in runs:
            label[start : start + length] = part["id"]
    return label


def compare(truth: Row, points: Floats, faces: Ints, label: Ints, prediction: Row) -> CaseScore:
    """Score a prediction on a mesh whose faces are labelled with the parts of the truth."""
    areas = face_normals(points, faces)[1]
    diagonal = float(np.linalg.norm(np.ptp(points[np.unique(faces)], axis=0)))
    known = [part for part in truth["parts"] if part["scored"] and areas[label == part["id"]].sum() > 0.0]
    ignored = np.isin(label, [part["id"] for part in truth["parts"] if not part["scored"]])
    found = [(part, _faces_of(part, len(faces))) for part in prediction.get("parts", [])]
    found = [
        (part, mine)
        for part, mine in found
        if part.get("joint", {}).get("type", "fixed") != "fixed"
        and not areas[mine & ignored].sum() > 0.5 * areas[mine].sum() > 0.0
    ]
    iou = np.zeros((len(known), len(found)))
    for i, part in enumerate(known):
        own = label == part["id"]
        for j, (_, mine) in enumerate(found):
            either = float(areas[own | mine].sum())
            iou[i, j] = float(areas[own & mine].sum()) / either if either > 0 else 0.0
    pairs = dict(zip(*(x.tolist() for x in linear_sum_assignment(-iou)), strict=True)) if iou.size else {}
    rows, matched, distances = [], set(), []
    for i, part in enumerate(known):
        j = pairs.get(i, -1)
        share = float(iou[i, j]) if j >= 0 else 0.0
        row = {"name": part["name"], "type": part["type"], "iou": round(share, 4), "found": share >= MIN_IOU}
        row |= {"joint": _joint_kind(part["joint"]), "interior": part.get("interior", False)}
        if share >= MIN_IOU:
            matched.add(j)
            corners = points[faces[label == part["id"]]].reshape(-1, 3)
            row |= _compare_joints(found[j][0], part, corners)
            distances.append(joint_distance(found[j][0]["joint"], part["joint"], corners.mean(axis=0), diagonal))
        else:
            distances.append(joint_distance(None, part["joint"], points.mean(axis=0), diagonal))
        row["mao"] = row.get("joint_right", False) and row["axis_right"] and row["origin_right"]
        row["right"] = bool(row["mao"] and row["direction_right"] is not False)
        rows.append(row)
    extra = [j for j in range(len(found)) if j not in matched]
    distances += [joint_distance(found[j][0]["joint"], None, points.mean(axis=0), diagonal) for j in extra]
    names = tuple(str(found[j][0].get("name", j)) for j in extra)
    return CaseScore(
        str(truth["name"]), str(truth["category"]), len(known), len(found), tuple(rows), names, tuple(distances)
    )


def _faces_of(part: Row, count: int) -> Mask:
    mine = np.zeros(count, dtype=bool)
    if "faces" in part:
        rows = np.asarray(part["faces"], dtype=np.int64)
        mine[rows[(rows >= 0) & (rows < count)]] = True
    for start, length in part.get("face_runs", []):
        mine[start : start + length] = True
    return mine


def _joint_kind(joint: Row) -> str:
    return "revolute" if joint["type"] in ("revolute", "continuous", "hinge") else "prismatic"


def _opening(joint: Row) -> Floats:
    """Return the unit axis, turned so that the joint opens towards it."""
    axis = np.asarray(joint["axis"], dtype=np.float64)
    low, high = joint.get("range") or (0.0, 1.0)
    return axis / max(float(np.linalg.norm(axis)), 1e-12) * (1.0 if abs(high) >= abs(low) else -1.0)


def _compare_joints(found: Row, part: Row, corners: Floats) -> dict[str, Any]:
    """Return which of type, joint, axis, place and direction of a matched part are right.

    Args:
        corners: (N, 3) of the faces of the part.
    """
    told, known = found["joint"], part["joint"]
    same = _joint_kind(told) == _joint_kind(known)
    kinds = [SAME_TYPE.get(str(k), k) for k in (found.get("type"), part["type"])]
    a, b = _opening(told), _opening(known)
    angle = math.degrees(math.acos(min(1.0, abs(float(a @ b)))))
    directed = same and part["type"] in DIRECTED and not (part["type"] == "tray" and _joint_kind(known) == "revolute")
    gap = 0.0
    if same and _joint_kind(known) == "revolute":
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        at, other = np.asarray(told["origin"], dtype=np.float64), np.asarray(known["origin"], dtype=np.float64)
        near = at + a * float((middle - at) @ a)
        apart = near - other
        size = max(float(np.linalg.norm(np.ptp(corners, axis=0))), 1e-12)
        gap = float(np.linalg.norm(apart - b * float(apart @ b))) / size
    return {
        "predicted": found.get("name", ""),
        "type_right": kinds[0] == kinds[1],
        "joint_right": same,
        "axis_deg": angle if same else None,
        "axis_right": same and angle <= MAX_AXIS_DEG,
        "origin_right": same and gap <= MAX_ORIGIN,
        "direction_right": bool(a @ b > 0) if directed else None,
    }


def joint_distance(told: Row | None, known: Row | None, origin: Floats, diagonal: float) -> float:
    """Return E of two joints; None is a fixed one. `origin`: that lengths are measured from; `diagonal`: their unit."""
    norm = make_split_norm(alpha=1.0)
    ends = [_twists(joint, origin, diagonal) for joint in (told, known)]
    return float(compactified_joint_metric(*ends[0], *ends[1], norm, KAPPA))


def _twists(joint: Row | None, origin: Floats, diagonal: float) -> tuple[Floats, Floats]:
    """Return the twists of a joint at both ends of its range."""
    if joint is None:
        return np.zeros(6), np.zeros(6)
    axis = np.asarray(joint["axis"], dtype=np.float64)
    at = (np.asarray(joint["origin"], dtype=np.float64) - origin) / diagonal
    kind = _joint_kind(joint)
    twist = np.asarray(screw_twist(axis / max(float(np.linalg.norm(axis)), 1e-12), at, kind).data)
    scale = diagonal if kind == "prismatic" else 1.0
    low, high = ((v / scale) for v in joint.get("range") or (0.0, 1.0))
    if joint["type"] == "continuous":
        low, high = -math.pi, math.pi
    return low * twist, high * twist


def totals(scores: Sequence[CaseScore]) -> dict[str, float]:
    """Return the figures of many cases together."""
    parts = [p for s in scores for p in s.parts]
    found = [p for p in parts if p["found"]]
    total = len(parts) + sum(s.predicted for s in scores)
    joints = [p for p in found if p["joint_right"]]
    doors = [p for p in joints if p["type"] in ("door", "lid") and p["direction_right"] is not None]

    def f1(count: int) -> float:
        return 2 * count / total if total else math.nan

    return {
        "cases": len(scores),
        "parts": len(parts),
        "predicted": sum(s.predicted for s in scores),
        "F1": f1(len(found)),
        "MAO": f1(sum(p["mao"] for p in parts)),
        "E": _mean([d for s in scores for d in s.distances]),
        "type": _mean([p["type_right"] for p in found]),
        "joint": _mean([p["joint_right"] for p in found]),
        "doors' direction": _mean([p["direction_right"] for p in doors]),
        "perfect": _mean([s.is_perfect for s in scores]),
        "mostly right": _mean([s.is_mostly_right for s in scores]),
    }


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else math.nan


def recall(scores: Sequence[CaseScore]) -> dict[str, tuple[int, float]]:
    """Return the number of parts of each type and the share that is found."""
    types = sorted({p["type"] for s in scores for p in s.parts})
    rows = {t: [p["found"] for s in scores for p in s.parts if p["type"] == t] for t in types}
    return {t: (len(found), _mean(found)) for t, found in rows.items()}
