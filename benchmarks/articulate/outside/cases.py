"""Merge an articulated object at its closed pose into a case: triangles alone, and the truth on its moving parts."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.articulate.labelled import LabelledMesh, fused, write_case, write_obj
from benchmarks.articulate.outside.model import UNSCORED, Joint, Link, Model, Unreadable, about
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.surface import face_components, merge_rows, weld

# Types of parts, by words in the names of a joint and its link; the first that fits counts.
WORDS = (
    ("button", r"button|btn|\bkey"),
    ("knob", r"knob|dial"),
    ("drawer", r"drawer|schublade|slide"),
    ("tray", r"tray|rack|turntable|shelf|plate|basket"),
    ("lid", r"\blid|cover|flap|\btop"),
    ("lever", r"lever|handle|switch|faucet|valve|tap\b|latch|pedal"),
    ("spout", r"spout|nozzle"),
    ("door", r"door|tuer|hinge|leaf|window"),
)
# A part whose longest side is at most this share of the diagonal is small: a control.
SMALL = 0.14
# Largest number of triangles of an object, and the fewest of one part.
MAX_FACES, MIN_PART_FACES = 400_000, 2
# Points nearer than this share of the diagonal are one in the welded variant.
WELDED = 1e-4
# How far parts that turn are opened to see where they go.
PEEK_RAD = 0.2


@dataclass(frozen=True)
class Part:
    """A moving part: what it is, its joint, and the name of the part that carries it, empty for the body."""

    name: str
    kind: str
    joint: Joint
    parent: str
    is_scored: bool


def build_case(
    folder: Path, model: Model, about_it: Mapping[str, Any], types: Mapping[str, str], still: str = ""
) -> dict[str, Any]:
    """Write the case of an object; return its truth.

    Args:
        about_it: of the truth: `category`, `origin`, `source`, `licence`. types: regular expression of a name of a
            joint or link -> type of its part, `fixed` to weld it to its parent, `unscored` to leave it out.
        still: regular expression of links that move in truth, though this copy of the object holds them still: nothing
            that is found on them is counted.
    Raises:
        Unreadable: it has no moving part, or too many triangles.
    """
    owner, parts = moving_parts(model, types, still)
    pieces = [(owner[link.name], corners) for link in model.links.values() for corners in link.meshes if len(corners)]
    count = sum(len(c) for _, c in pieces)
    if count > MAX_FACES:
        raise Unreadable(f"{count} triangles; at most {MAX_FACES} are taken")
    if not count or not any(p.is_scored for p in parts):
        raise Unreadable("it has no moving part with a surface")
    points, faces, label = merged(pieces)
    corners = points[faces]
    rows = []
    for number, part in enumerate(parts, 1):
        if np.count_nonzero(label == number) < MIN_PART_FACES:
            raise Unreadable(f"'{part.name}' has no surface")
        rows.append(_row(number, part))
    truth = {
        "name": folder.name,
        **about_it,
        "up": model.up.tolist(),
        "front": _front(rows, corners[label > 0], label[label > 0], model.up),
        "parts": rows,
    }
    seen, shell = fused(LabelledMesh(points, faces, label, truth))
    for row in seen.truth["parts"]:
        row["interior"] = row["visible"] < 0.05
    write_case(folder, seen, shell)
    extent = float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    one, place = weld(points, WELDED * extent / max(float(np.ptp(points, axis=0).max()), 1e-12))
    write_obj(folder / "welded.obj", one, place[faces])
    return read_truth(folder)


def moving_parts(model: Model, types: Mapping[str, str], still: str = "") -> tuple[dict[str, int], list[Part]]:
    """Return the number of the part that each link is of, 0 for the body, and the parts; as `build_case`."""
    owner: dict[str, int] = {}
    found: list[tuple[Link, str, int]] = []
    whole = np.concatenate([c for link in model.links.values() for c in link.meshes] or [np.zeros((1, 3, 3))])
    diagonal = float(np.linalg.norm(np.ptp(whole.reshape(-1, 3), axis=0)))
    held_still = [link for link in model.links.values() if still and link.parent and link.joint is None]
    held_still = [link for link in held_still if re.search(still, link.name) and link.meshes]
    # The largest is the body.
    body = max(held_still, key=lambda link: _bulk(model, link), default=None)
    for link in model.links.values():
        carrier = owner.get(link.parent, 0)
        owner[link.name] = carrier
        held = any(link is other for other in held_still) and link is not body
        if (link.joint is None and not held) or not _surface(model, link):
            continue
        if link.joint is None:
            found.append(
                (replace(link, joint=Joint("", "continuous", model.up, np.zeros(3), (0.0, 0.0))), "unscored", 0)
            )
            owner[link.name] = len(found)
            continue
        kind = _stated(types, link) or type_of(link, model, diagonal)
        if kind != "fixed":
            found.append((link, kind, carrier))
            owner[link.name] = len(found)
    parts = []
    for link, kind, carrier in found:
        assert link.joint is not None
        words = f"{link.name} {link.joint.name}".lower()
        scored = kind != "unscored" and not any(word in words for word in UNSCORED)
        parent = f"part_{carrier - 1}" if carrier else "base"
        parts.append(Part(f"part_{len(parts)}", kind, link.joint, parent, scored))
    return owner, parts


def _surface(model: Model, link: Link) -> list[Floats]:
    """Return the meshes of a link with all that is fixed to it."""
    out = list(link.meshes)
    for other in model.links.values():
        if other.parent == link.name and other.joint is None and other is not link:
            out += _surface(model, other)
    return out


def _bulk(model: Model, link: Link) -> float:
    """Return the volume of the box around a link."""
    return float(np.ptp(np.concatenate(_surface(model, link)).reshape(-1, 3), axis=0).prod())


def _stated(types: Mapping[str, str], link: Link) -> str:
    names = (link.name, link.joint.name if link.joint else "")
    return next((kind for pattern, kind in types.items() if any(re.search(pattern, n) for n in names)), "")


def type_of(link: Link, model: Model, diagonal: float) -> str:
    """Return the type of a moving part by its names, else by its joint and size."""
    joint = link.joint
    assert joint is not None
    extent = np.ptp(np.concatenate(_surface(model, link)).reshape(-1, 3), axis=0)
    small = float(extent.max()) <= SMALL * diagonal
    slides = joint.kind == "prismatic"
    for kind, pattern in WORDS:
        names = f"{joint.name} {link.name}".lower().replace("_", " ")
        fits = {"drawer": slides and not small, "door": not small, "knob": not slides, "spout": not slides}
        if re.search(pattern, names) and fits.get(kind, True):
            return kind
    if slides:
        return "button" if small else "drawer"
    if small:
        return "knob" if joint.kind == "continuous" else "lever"
    level = abs(float(joint.axis @ model.up)) < 0.5
    return "lid" if level and _faces_up(link, model) else "door"


def _faces_up(link: Link, model: Model) -> bool:
    corners = np.concatenate(_surface(model, link))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    along = np.abs(normal @ model.up).sum()
    return bool(along > 0.6 * np.linalg.norm(normal, axis=1).sum())


def merged(pieces: list[tuple[int, Floats]]) -> tuple[Floats, Ints, Ints]:
    """Merge pieces into one mesh whose connected components stand in an order that says nothing.

    Returns:
        (P, 3) points, equal ones of one piece merged; (F, 3) faces; (F,) number of the part of each.
    """
    rows = []
    for part, corners in pieces:
        points, place = merge_rows(corners.reshape(-1, 3))
        place = place.reshape(-1, 3)
        points = corners.reshape(-1, 3)[points] if points.ndim == 1 else points
        component = face_components(place, len(points))
        for c in np.unique(component):
            faces = place[component == c]
            used, at = np.unique(faces, return_inverse=True)
            cloud = points[used]
            key = np.round(np.concatenate([cloud.mean(axis=0), np.ptp(cloud, axis=0), [len(faces)]]), 6).tolist()
            rows.append((key, cloud, at.reshape(-1, 3), part))
    rows.sort(key=lambda row: (row[0], row[3]))
    starts = np.cumsum([0, *(len(cloud) for _, cloud, _, _ in rows)])
    faces = np.concatenate([f + s for (_, _, f, _), s in zip(rows, starts, strict=False)])
    label = np.concatenate([np.full(len(f), part, dtype=np.int64) for _, _, f, part in rows])
    return np.concatenate([cloud for _, cloud, _, _ in rows]), faces.astype(np.int64), label


def _row(number: int, part: Part) -> dict[str, Any]:
    """Return the truth on a part."""
    joint = part.joint
    return {
        "id": number,
        "name": part.name,
        "type": part.kind,
        "stated": joint.name,
        "parent": part.parent,
        "scored": part.is_scored,
        "joint": {
            "type": joint.kind,
            "axis": joint.axis.tolist(),
            "origin": joint.origin.tolist(),
            "range": [float(r) for r in joint.range],
        },
    }


def _front(rows: list[dict[str, Any]], corners: Floats, label: Ints, up: Floats) -> list[float] | None:
    """Return the axis that fronts move along when they open; None where none moves level."""
    total = np.zeros(3)
    for row in rows:
        if row["type"] not in ("door", "drawer") or not row["scored"]:
            continue
        cloud = corners[label == row["id"]].reshape(-1, 3)
        joint = row["joint"]
        axis, reach = np.array(joint["axis"]), max(joint["range"], key=abs)
        if joint["type"] == "prismatic":
            step = axis * np.sign(reach)
        else:
            angle = np.sign(reach) * min(abs(reach), PEEK_RAD)
            origin = np.array(joint["origin"])
            step = ((cloud - origin) @ about(axis, angle).T + origin - cloud).mean(axis=0)
        step = step - up * float(step @ up)
        size = float(np.linalg.norm(step))
        total += step / size if size > 1e-9 else 0.0
    if float(np.linalg.norm(total)) < 0.3:
        return None
    k = int(np.argmax(np.abs(total)))
    out = np.zeros(3)
    out[k] = np.sign(total[k])
    return [float(v) for v in out]


def read_truth(folder: Path) -> dict[str, Any]:
    """Return gt.json of a case."""
    return dict(json.loads((folder / "gt.json").read_text(encoding="utf-8")))
