"""Measure the colours of an asset by area: a histogram to compare assets by, and names of colours."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from casa_assets.core.numeric import Floats, decimals, linear_from_srgb_array
from casa_assets.mesh.registration import quantile_means
from casa_assets.mesh.solid.deviation import barycentric_samples
from casa_assets.mesh.surface import face_normals
from casa_assets.model.asset.asset import TONE_SHARES, Asset, ColorHistogram, Visual
from casa_assets.model.asset.material import Material

# Places on all surfaces together whose colour is looked up.
PLACES = 6000
# Shares of the surface below which a colour is not named.
NAMED = 0.1
# Grey that is as light and as even as this is what readers fill in where a file says nothing, CIELAB units.
PLAIN_LIGHT, PLAIN_CHROMA, PLAIN_EVEN = 75.0, 3.0, 1.5
# What is greyer than this has no hue; darker is black, lighter is white.
GREY_CHROMA, BLACK_LIGHT, WHITE_LIGHT = 14.0, 22.0, 85.0
# Hue in degrees from which on a colour has its name.
WARM = ((0.0, "red"), (46.0, "orange"), (72.0, "yellow"))
HUES = (*WARM, (108.0, "green"), (185.0, "turquoise"), (225.0, "blue"), (305.0, "purple"), (335.0, "red"))
# Dark orange and yellow are brown, light red is pink, what is pale between red and green is beige.
BROWN_LIGHT, PINK_LIGHT, BEIGE_CHROMA, BEIGE_LIGHT = 52.0, 66.0, 32.0, 60.0
# Ref: IEC 61966-2-1, linear sRGB to XYZ, over the white of D65.
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = TO_XYZ.sum(axis=1)


def color_histogram(asset: Asset) -> ColorHistogram:
    """Distribution of the visible colours of an asset."""
    looks = {m.id: m for m in asset.materials}
    seen = [(v, looks[v.material]) for link in asset.links for v in link.visuals]
    areas = np.array([face_normals(v.mesh.vertices, v.mesh.faces.astype(np.int64))[1].sum() for v, _ in seen])
    counts = np.maximum(1, np.rint(PLACES * areas / max(float(areas.sum()), 1e-30)).astype(np.int64))
    lab = np.concatenate([lab_of(_colors(v, look, int(n))) for (v, look), n in zip(seen, counts, strict=True)])
    textured = any(look.base_color_texture is not None for _, look in seen)
    chroma = np.hypot(lab[:, 1], lab[:, 2])
    even = float(np.ptp(lab[:, 0])) <= PLAIN_EVEN and float(chroma.max()) <= PLAIN_CHROMA
    return ColorHistogram(
        tones=_tones(lab), names=_names(lab), stated=textured or not (even and float(lab[:, 0].min()) >= PLAIN_LIGHT)
    )


def color_distance(one: ColorHistogram, other: ColorHistogram) -> float:
    """Distance of two colour distributions, wherever the colours lie, CIELAB units; 2 is hardly seen."""
    return float(np.abs(np.subtract(one.tones, other.tones)).mean())


def lab_of(linear: Floats) -> Floats:
    """(N, 3) CIELAB from (N, 3) linear sRGB in 0..1. Ref: CIE 15:2004."""
    ratio = linear @ TO_XYZ.T / WHITE
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def _colors(visual: Visual, look: Material, count: int) -> Floats:
    """(count, 3) linear colours at places spread evenly over a surface."""
    base = np.array(look.base_color[:3])
    picture, uv = look.base_color_texture, visual.mesh.uv
    if picture is None or uv is None:
        return np.tile(base, (count, 1))
    faces = visual.mesh.faces.astype(np.int64)
    sample, u, v = barycentric_samples(visual.mesh.vertices, faces, count)
    face = faces[sample]
    at = uv[face[:, 0]] * (1 - u - v)[:, None] + uv[face[:, 1]] * u[:, None] + uv[face[:, 2]] * v[:, None]
    with Image.open(io.BytesIO(picture.png)) as opened:
        pixels = np.asarray(opened.convert("RGB"))
    height, width = pixels.shape[:2]
    column = np.minimum((at[:, 0] % 1.0 * width).astype(np.int64), width - 1)
    row = np.minimum(((1 - at[:, 1]) % 1.0 * height).astype(np.int64), height - 1)
    shown = pixels[row, column] / 255.0
    return np.asarray(base * linear_from_srgb_array(shown))


def _tones(lab: Floats) -> tuple[float, ...]:
    light, a, b = lab.T
    tones = (light, a, b, (a + b) / np.sqrt(2.0), (a - b) / np.sqrt(2.0))
    return tuple(decimals(share, 2) for tone in tones for share in quantile_means(tone, TONE_SHARES))


def _names(lab: Floats) -> tuple[tuple[str, float], ...]:
    words, shares = np.unique([_name(*row) for row in lab.tolist()], return_counts=True)
    order = sorted(range(len(words)), key=lambda i: (-int(shares[i]), str(words[i])))
    found = [(str(words[i]), round(float(shares[i]) / len(lab), 2)) for i in order]
    return tuple(pair for pair in found if pair[1] >= NAMED)


def _name(light: float, a: float, b: float) -> str:
    chroma, hue = float(np.hypot(a, b)), float(np.degrees(np.arctan2(b, a)) % 360.0)
    if light < BLACK_LIGHT and chroma < 2 * GREY_CHROMA:
        return "black"
    if chroma < GREY_CHROMA:
        return "white" if light > WHITE_LIGHT else "grey"
    word = [name for start, name in HUES if hue >= start][-1]
    if word in ("orange", "yellow") and chroma < BEIGE_CHROMA and light > BEIGE_LIGHT:
        return "beige"
    if word in ("orange", "yellow") and light < BROWN_LIGHT:
        return "brown"
    return "pink" if word == "red" and light > PINK_LIGHT else word
