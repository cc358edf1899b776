"""Find packages whose print cannot be read from 20 cm (OBJ002 to OBJ004)."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.checks.check import Measurement, all_at_least, least
from casa_assets.checks.objects.member import ObjectMember
from casa_assets.checks.objects.print_size import LineOnSurface, lines_on_surface

NO_PRINT = "nothing is printed on it"
# The camera that reads: a common one on a wrist, 640 pixels wide with 60 degrees, 20 cm before the middle of the line.
DISTANCE_M, WIDE_PX, FIELD_DEG = 0.2, 640, 60.0
FOCAL_PX = WIDE_PX / 2 / math.tan(math.radians(FIELD_DEG) / 2)
# A letter that is turned away by more than this, 75 degrees, is less than a quarter as wide as on the label and not
# read; of a line, so many may be. Both are choices: on a round bottle a long name always ends near the edge.
SEEN_COS, UNSEEN_SHARE = 0.25, 0.2
# A line is as high as the lowest of what is seen of it; one place in twenty may lie on a crease of the paper.
LOW_PERCENT = 5


def letters_are_large(member: ObjectMember, limit: float) -> Measurement:
    """OBJ002: height of the letters in the picture of a camera at 20 cm, pixels; the least of the printed lines."""
    heights, problems = [], []
    for line in lines_on_surface(member):
        height, unseen = seen_from(line)
        heights.append(height)
        where = f"materials/{line.material}"
        if line.mirrored > 0.5:
            problems.append((where, f"shows {line.text!r} mirrored; turn its texture coordinates"))
        elif unseen > UNSEEN_SHARE:
            message = f"bends {unseen:.0%} of {line.text!r} out of sight; make the front of the label narrower"
            problems.append((where, message))
        elif height < limit:
            problems.append((where, f"{line.text!r} is {height:.1f} pixels high at 20 cm; make its letters larger"))
    return least(heights, problems, NO_PRINT)


def letters_are_resolved(member: ObjectMember, limit: float) -> Measurement:
    """OBJ003: height of the letters in the picture that is laid on, pixels; the least of the printed lines."""
    heights = {f"materials/{line.material}": line.height_px for line in _worst(member, "height_px")}
    return all_at_least(heights, limit, "has letters of {:.0f} pixels; enlarge them, or the picture", NO_PRINT)


def letters_stand_out(member: ObjectMember, limit: float) -> Measurement:
    """OBJ004: contrast ratio of the letters to what is around them, 1..21; the least of the printed lines."""
    contrasts = {f"materials/{line.material}": line.contrast for line in _worst(member, "contrast")}
    return all_at_least(contrasts, limit, "has letters at {:.1f} to 1 from their ground; change a colour", NO_PRINT)


def seen_from(line: LineOnSurface) -> tuple[float, float]:
    """Height of the lowest letters in pixels of the camera; share of the line that is turned out of sight."""
    middle, look = line.points.mean(axis=0), line.normals.mean(axis=0)
    camera = middle + DISTANCE_M * look / max(float(np.linalg.norm(look)), 1e-9)
    rays = line.points - camera
    distance = np.linalg.norm(rays, axis=1)
    rays /= distance[:, None]
    across = line.up - np.sum(line.up * rays, axis=1)[:, None] * rays
    heights = FOCAL_PX * np.linalg.norm(across, axis=1) / distance
    seen = -np.sum(line.normals * rays, axis=1) >= SEEN_COS
    return float(np.percentile(heights[seen], LOW_PERCENT)) if seen.any() else 0.0, 1.0 - float(seen.mean())


def _worst(member: ObjectMember, field: str) -> list[LineOnSurface]:
    """The line of each material whose number is the lowest, the lowest last."""
    return sorted(lines_on_surface(member), key=lambda line: -float(getattr(line, field)))
