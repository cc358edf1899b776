"""Render one asset's `model.xml` as a short animation from all sides."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from casa_assets.core.typing import Floats
from casa_assets.preview import still, studio, tonemap
from casa_assets.preview.camera import View, fit

_STANDARD = View(size_px=256, fill=0.92, passes=10)


def render(model_xml: Path, view: View = _STANDARD, frames: int = 24, seconds: float = 4.0) -> bytes:
    """Animated WebP of the asset turning once, without end.

    Args:
        model_xml: as for `still.render`.
        view: the first frame.
        frames: pictures per turn.
        seconds: duration of a turn.
    Raises:
        CannotDraw: MuJoCo cannot read the model, or nothing in it is visible.
        NoRenderer: there is no OpenGL.
    """
    model, data, points = still.load_into_studio(model_xml, view.size_px)
    swept = _swept(points)
    taken: list[tonemap.Pixels] = []
    for i in range(frames):
        # The camera walks round with the lights, which looks as if the thing turned under them.
        turned = replace(view, azimuth_deg=view.azimuth_deg + 360.0 * i / frames)
        camera = fit(swept, turned)
        taken.append(studio.render(model, data, points, camera, turned))
    return _webp(taken, round(1000.0 * seconds / frames))


def _swept(points: Floats) -> Floats:
    """Rings about the vertical axis that hold all points, so that every frame has the same distance and aim."""
    middle = (points[:, :2].max(axis=0) + points[:, :2].min(axis=0)) / 2.0
    radius = np.linalg.norm(points[:, :2] - middle, axis=1)
    around = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
    rings = []
    # The widest point of each of some layers is enough.
    edges = np.linspace(points[:, 2].min(), points[:, 2].max(), 17)
    layer = np.clip(np.searchsorted(edges, points[:, 2], side="right") - 1, 0, 15)
    for k in range(16):
        mine = layer == k
        if mine.any():
            reach = float(radius[mine].max())
            for z in (float(points[mine, 2].min()), float(points[mine, 2].max())):
                x, y = middle[0] + reach * np.cos(around), middle[1] + reach * np.sin(around)
                rings.append(np.stack([x, y, np.full_like(x, z)], axis=1))
    return np.concatenate(rings)


def _webp(frames: list[tonemap.Pixels], milliseconds: int) -> bytes:
    """Animated WebP, always with the same options."""
    first, *rest = [Image.fromarray(f) for f in frames]
    out = io.BytesIO()
    first.save(
        out, format="WEBP", save_all=True, append_images=rest, duration=milliseconds, loop=0, quality=80, method=4
    )
    return out.getvalue()
