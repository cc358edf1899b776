"""Render an articulated asset as a strip: closed, coloured by part, exploded, and each joint open."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from casa_assets.core.numeric import Floats
from casa_assets.show.stills import pictures, studio
from casa_assets.show.stills.pictures import Pixels, SheetCell, cell_corner, contact_sheet
from casa_assets.show.stills.still import load_into_studio
from casa_assets.show.stills.studio import Camera, View, fit

CELL_PX, COLUMNS = 320, 6
# A review wants to see what is there, not soft shadows.
_VIEW = View(size_px=CELL_PX, passes=6)
_BODY = (0.82, 0.83, 0.85)
# Parts that are taken apart go this far, in diagonals of the thing; what sits on a part goes as far again.
_APART = 0.16
_DARK = (25, 27, 31)


@dataclass(frozen=True)
class MovingJoint:
    """A joint to be shown: its name in the model, and two lines under its picture.

    Attributes:
        alone: it gets a separate picture, open; a joint that moves a few millimetres would show nothing there.
    """

    joint: str
    title: str
    subtitle: str
    alone: bool = True


def joint_strip(model_xml: Path, moving: Sequence[MovingJoint], heading: str) -> bytes:
    """PNG: closed, coloured with axes, taken apart, all open, then each joint of `moving` open alone.

    Args:
        model_xml: MJCF file as `still.render` takes it.
        moving: in the order in which they are shown. heading: one line at the top.
    Raises:
        CannotDraw: MuJoCo cannot read the model, or it has nothing to show.
        NoRenderer: there is no OpenGL.
    """
    model, data, _ = load_into_studio(model_xml, CELL_PX)
    before = _behind(model)
    ends = {m.joint: float(max(model.joint(m.joint).range, key=abs)) for m in moving}
    every = {name: (end if abs(end) < 3.0 else end / 8) for name, end in ends.items()}
    shots = [SheetCell("closed", f"{len(moving)} moving part{'s' * (len(moving) != 1)}", _shot(model, data, {}))]
    names = [m.joint for m in moving]
    shots.append(SheetCell("parts", "one colour each, with the axis", _painted(model, data, names)))
    shots.append(SheetCell("taken apart", "", _apart(model, data, names)))
    if sum(m.alone for m in moving) > 1:
        shots.append(SheetCell("all open", "", _shot(model, data, every)))
    for m in moving:
        if m.alone:
            pose = {m.joint: every[m.joint], **{b: ends[b] for b in before.get(m.joint, ()) if b in ends}}
            shots.append(SheetCell(m.title, m.subtitle, _shot(model, data, pose)))
    return contact_sheet(shots, heading, min(COLUMNS, len(shots)), CELL_PX)


def strip_corners(moving: Sequence[MovingJoint]) -> dict[str, tuple[int, int]]:
    """Return the pixel (x, y) of the upper left corner of pictures on the strip of some joints.

    Those of the whole are `closed`, `parts` and `taken apart`; that of a joint that is shown alone has its name.
    """
    alone = [m.joint for m in moving if m.alone]
    names = ["closed", "parts", "taken apart", *(["all open"] if len(alone) > 1 else []), *alone]
    return {name: cell_corner(i, min(COLUMNS, len(names)), CELL_PX) for i, name in enumerate(names)}


def _behind(model: Any) -> dict[str, tuple[str, ...]]:
    """Joint -> joints that must be open before it can move, from the texts `behind__<joint>` of the model."""
    found: dict[str, tuple[str, ...]] = {}
    for i in range(model.ntext):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, i)
        start, size = int(model.text_adr[i]), int(model.text_size[i])
        if name.startswith("behind__"):
            found[name.removeprefix("behind__")] = (bytes(model.text_data[start : start + size - 1]).decode(),)
    return found


def _stand(model: Any, data: Any, pose: Mapping[str, float]) -> Floats:
    """Put joints at values, the rest at zero; (N, 3) points of what is seen, metres."""
    data.qpos[:] = model.qpos0
    for name, value in pose.items():
        data.qpos[int(model.jnt_qposadr[model.joint(name).id])] = value
    mujoco.mj_forward(model, data)
    return studio.place_floor(model, data)


def _shot(model: Any, data: Any, pose: Mapping[str, float]) -> bytes:
    return _picture(model, data, _stand(model, data, pose))


def _picture(model: Any, data: Any, points: Floats) -> bytes:
    return pictures.png(studio.render(model, data, points, fit(points, _VIEW), _VIEW, both_sides=True))


def _apart(model: Any, data: Any, names: Sequence[str]) -> bytes:
    """Every part moved off what carries it, away from the middle of the thing."""
    points = _stand(model, data, {})
    low, high = points.min(axis=0), points.max(axis=0)
    reach = _APART * float(np.linalg.norm(high - low))
    moved: dict[int, Floats] = {}
    bodies = {int(model.jnt_bodyid[model.joint(n).id]) for n in names}
    for body in range(1, model.nbody):
        offset = moved.get(int(model.body_parentid[body]), np.zeros(3))
        geoms = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) == body]
        if body in bodies and geoms:
            middle = np.mean([data.geom_xpos[g] for g in geoms], axis=0)
            off = offset if offset.any() else (middle - (low + high) / 2) / np.maximum(high - low, 1e-9)
            side = int(np.argmax(np.abs(off)))
            offset = offset + np.eye(3)[side] * np.sign(off[side] or 1.0) * reach
        moved[body] = offset
    for g in range(model.ngeom):
        data.geom_xpos[g] += moved.get(int(model.geom_bodyid[g]), np.zeros(3))
    return _picture(model, data, studio.place_floor(model, data))


def _painted(model: Any, data: Any, names: Sequence[str]) -> bytes:
    """Picture with every part in a different colour and the axes drawn over it; the model keeps its looks."""
    kept = model.geom_matid.copy(), model.geom_rgba.copy()
    points = _stand(model, data, {})
    colour = {int(model.jnt_bodyid[model.joint(n).id]): part_color(i) for i, n in enumerate(names)}
    floor = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) == 0 and model.geom_type[g] == 0]
    for g in range(model.ngeom):
        if g in floor:
            continue
        body = int(model.geom_bodyid[g])
        while body and body not in colour:
            body = int(model.body_parentid[body])
        model.geom_matid[g], model.geom_rgba[g] = -1, [*colour.get(body, _BODY), 1.0]
    camera = fit(points, replace(_VIEW, fill=0.7))
    picture = studio.render(model, data, points, camera, _VIEW, both_sides=True)
    model.geom_matid[:], model.geom_rgba[:] = kept
    return _with_axes(picture, camera, model, data, names)


def _with_axes(picture: Pixels, camera: Camera, model: Any, data: Any, names: Sequence[str]) -> bytes:
    """An arrow along each joint's axis, numbered as the parts are listed."""
    image = Image.fromarray(picture)
    pen = ImageDraw.Draw(image)
    font = ImageFont.load_default(12)
    extent = float(model.stat.extent)
    for i, name in enumerate(names):
        joint = model.joint(name).id
        axis, middle = np.array(data.xaxis[joint]), np.array(data.xanchor[joint])
        body = int(model.jnt_bodyid[joint])
        size = max((float(model.geom_rbound[g]) for g in range(model.ngeom) if model.geom_bodyid[g] == body), default=0)
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE:
            middle = np.array(data.xipos[body])
        axis = axis * np.sign(float(max(model.jnt_range[joint], key=abs)) or 1.0)
        half = axis * max(1.05 * size, 0.05 * extent)
        turns = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        x, y, _ = camera.project(np.array([middle - half if turns else middle, middle + half]))
        at = [((float(a) + 1) / 2 * CELL_PX, (1 - float(b)) / 2 * CELL_PX) for a, b in zip(x, y, strict=True)]
        ink = tuple(int(255 * 0.62 * c) for c in part_color(i))
        pen.line(at, fill=(255, 255, 255), width=5)
        pen.line(at, fill=ink, width=3)
        pen.ellipse((at[1][0] - 5, at[1][1] - 5, at[1][0] + 5, at[1][1] + 5), fill=ink, outline=(255, 255, 255))
        pen.text(
            (at[1][0] + 7, at[1][1] - 8), str(i), fill=_DARK, font=font, stroke_width=2, stroke_fill=(255, 255, 255)
        )
    return pictures.png(np.asarray(image))


def part_color(i: int) -> tuple[float, float, float]:
    """Red, green and blue, 0..1, of the i-th part where parts are coloured; neighbours differ well."""
    return colorsys.hsv_to_rgb((0.02 + i * 0.61803398875) % 1.0, (0.72, 0.5)[i % 2], (0.95, 0.85)[i // 2 % 2])
