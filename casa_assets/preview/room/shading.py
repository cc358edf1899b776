"""Light on surfaces into the colours of a picture: matt, metal and polish, glass before it, the tone curve."""

from __future__ import annotations

import numpy as np

from casa_assets.core.color import linear_from_srgb_array, srgb_from_linear_array
from casa_assets.core.typing import Floats, Singles
from casa_assets.preview.room.lighting import KEY, KEY_COLOR
from casa_assets.preview.room.surfaces import Surfaces
from casa_assets.preview.room.surroundings import Surroundings

# Chosen by eye, as are the lights: a white wall keeps its shading, a black front its form.
_EXPOSURE = 0.78
_SHOULDER, _ABOVE = 0.6, 0.42  # where the tone curve begins to bend, and how much brighter it gets
_MATT = 0.95  # what a surface throws back of its colour
_GLOW = 1.3  # of what shines by itself
_FREE_LIGHT = 0.8  # on a place with nothing near it; with less, its reflections are dimmer
_LEAST_REFLECTED = 0.04  # of light that comes straight on. Ref: Schlick 1994.
_MIRROR_BLUR = 0.8  # of the edges of the room, as metal and polish mirror it
_VEIL = 0.9  # light on glass
_PAPER = 0.955  # sRGB of what lies beyond a room that is seen from outside
_HORIZON, _ZENITH = np.array([0.925, 0.945, 0.96]), np.array([0.70, 0.82, 0.93])  # of the sky that is seen from within


def shade(seen: Surfaces, light: Singles, room: Surroundings, is_inside: bool) -> Floats:
    """(H, W, 3) sRGB, 0..1, of a drawing.

    Args:
        light: (H, W, 3) on its surfaces; 1 makes white look white.
        is_inside: whether the eye is in the room, and sees the sky through windows.
    """
    color = linear_from_srgb_array(seen.albedo)
    metallic, rough, glow = (seen.gloss[..., k : k + 1] for k in range(3))
    reflected = _reflections(seen, light, room, rough)
    facing = np.clip(np.einsum("ijk,ijk->ij", seen.normals, seen.to_eye), 0.0, 1.0)[..., None]
    polish = (1.0 - rough) ** 2 * (_LEAST_REFLECTED + (1.0 - _LEAST_REFLECTED) * (1.0 - facing) ** 5)
    lit = color * ((1.0 - metallic) * _MATT * light + metallic * reflected + _GLOW * glow)
    lit += (1.0 - metallic) * polish * reflected
    tone = srgb_from_linear_array(_curve(lit * np.float32(_EXPOSURE)))
    behind = _sky(seen) if is_inside else np.float32(_PAPER)
    tone = np.where(seen.seen[..., None], tone, behind)
    return np.asarray(tone * seen.clear + np.float32(_VEIL) * seen.veil, dtype=np.float64)


def _reflections(seen: Surfaces, light: Singles, room: Surroundings, rough: Singles) -> Singles:
    """(H, W, 3) of the room and the key light, as the surfaces mirror them; rough ones mix it with the light there."""
    facing = np.einsum("ijk,ijk->ij", seen.normals, seen.to_eye)[..., None]
    away = 2.0 * facing * seen.normals - seen.to_eye
    shape = seen.places.shape
    mirrored = room.seen(seen.places.reshape(-1, 3).T, away.reshape(-1, 3).T, _MIRROR_BLUR).reshape(shape)
    blur = 0.015 + 0.25 * rough**2
    mirrored += KEY_COLOR * (0.05 / blur) * np.exp((away @ KEY.astype(np.float32) - 1.0)[..., None] / blur)
    free = np.clip(light.mean(axis=2, keepdims=True) / _FREE_LIGHT, 0.0, 1.0)
    return np.asarray(free * ((1.0 - 0.5 * rough) * mirrored + 0.5 * rough * light), dtype=np.float32)


def _curve(light: Singles) -> Singles:
    """The tone curve: straight in the dark, bent where it nears white."""
    bent = np.float32(_SHOULDER) + np.float32(_ABOVE) * np.tanh((light - _SHOULDER) / np.float32(_ABOVE))
    return np.where(light > _SHOULDER, np.minimum(bent, 1.0), light)


def _sky(seen: Surfaces) -> Floats:
    """(H, W, 3) sRGB of the sky behind each pixel: pale at the horizon, and as pale below it."""
    rise = np.clip(-1.6 * seen.to_eye[..., 2:], 0.0, 1.0)
    return np.asarray(_HORIZON + rise * (_ZENITH - _HORIZON))
