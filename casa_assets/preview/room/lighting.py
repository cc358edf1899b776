"""Light on surfaces, from many directions, each with shadows of its own.

A direction sends what the room shows there (`surroundings.py`) wherever nothing stands between. What stands near hides
all of it; what stands far gives some light of its own instead, as things in a room do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats, Singles
from casa_assets.preview.exposure import GOLDEN, PLASTIC
from casa_assets.preview.room.shadow_maps import ShadowMap
from casa_assets.preview.room.surfaces import Surfaces
from casa_assets.preview.room.surroundings import Surroundings

# The key light: from the open side, above, a little from the left, as of a large window behind the viewer.
KEY = np.array([-0.42, -0.72, 0.55]) / np.linalg.norm([-0.42, -0.72, 0.55])
KEY_COLOR = np.array([1.18, 1.15, 1.10], dtype=np.float32)
_KEY_SOFTNESS = 0.09  # half the width of its soft box, rad
_TILT = 0.2  # by which each pixel turns a direction, so that shadows have no steps, rad
_NEAR_M, _FAR_M = 0.03, 1.4  # what hides a place at this distance is black; from the other on it gives most light
_SECOND_HAND = np.array([0.36, 0.345, 0.325], dtype=np.float32)  # light of what stands between, far away
_FIRST_HAND = np.array([0.02, 0.019, 0.018], dtype=np.float32)
_ON_CEILING, _ON_OPEN_SIDE = np.float32(0.4), np.float32(0.45)
_GUESS_M = 0.2  # how far off a shadow is looked for where none is


@dataclass(frozen=True)
class Beam:
    """A direction that light comes from.

    Attributes:
        towards: (3,) unit vector to the light. is_key: it is the key light.
        weight: share of the light of its drawing that it stands for.
    """

    towards: Floats
    weight: float
    is_key: bool


def beams(number: int, passes: int, per_pass: int) -> Iterator[Beam]:
    """Directions of drawing `number` of `passes`: one of the key light, the others all over the sphere."""
    spread, turn = _KEY_SOFTNESS * math.sqrt((number + 0.5) / passes), 2.0 * math.pi * GOLDEN * number
    side = np.cross((0.0, 0.0, 1.0), KEY)
    side /= np.linalg.norm(side)
    up = np.cross(KEY, side)
    key = KEY + spread * (math.cos(turn) * side + math.sin(turn) * up)
    yield Beam(key / np.linalg.norm(key), 1.0, True)
    total = passes * per_pass
    for k in range(per_pass):
        # A Fibonacci lattice on the sphere, dealt out like cards so that each drawing has some of all heights.
        n = k * passes + number
        share = (n + 0.5) / total
        # Below the horizon half as dense as above, and with twice the weight.
        z, weight = (-1.0 + 3.0 * share, 1.5) if share < 1 / 3 else (1.5 * (share - 1 / 3), 0.75)
        flat, around = math.sqrt(max(0.0, 1.0 - z * z)), 2.0 * math.pi * GOLDEN * n
        # Light of the whole sphere, times the cosine, adds up to a quarter of its area over pi: four makes one of it.
        yield Beam(np.array([flat * math.cos(around), flat * math.sin(around), z]), 4.0 * weight / per_pass, False)


class Receiver:
    """Surfaces of a drawing that gather light.

    Places are moved off their surface by a pixel of the maps, so that it does not shade itself.
    """

    def __init__(self, surfaces: Surfaces, off_m: float, number: int) -> None:
        self._shape = surfaces.seen.shape
        self._at = np.flatnonzero(surfaces.seen)
        self._normals = np.ascontiguousarray(surfaces.normals.reshape(-1, 3)[self._at].T)
        self._places = np.ascontiguousarray(surfaces.places.reshape(-1, 3)[self._at].T)
        self._places += np.float32(off_m) * self._normals
        rows, columns = np.divmod(self._at, self._shape[1])
        # Two low-discrepancy sequences over the pixels: neighbours get values far apart. Ref: M. Roberts, R2.
        self._noise = np.stack(
            [
                (rows / PLASTIC + columns / PLASTIC**2 + number * GOLDEN) % 1.0,
                (rows / PLASTIC**2 - columns / PLASTIC + number * GOLDEN**2) % 1.0,
            ]
        ).astype(np.float32)
        self._light = np.zeros((len(self._at), 3), dtype=np.float32)

    def add(self, beam: Beam, shadow: ShadowMap, room: Surroundings, turn: float) -> None:
        """Add the light of a direction. `turn`: of the pixels' noise, different for each direction, 0..1."""
        cosine = np.dot(beam.towards.astype(np.float32), self._normals)
        lit = np.flatnonzero(cosine > 0.01)
        if not len(lit):
            return
        places = self._places[:, lit]
        noise = self._noise[:, lit]
        noise += np.array([[turn], [turn * GOLDEN]], dtype=np.float32)
        noise -= np.floor(noise)
        noise -= np.float32(0.5)
        noise *= np.float32(2.0 * (_KEY_SOFTNESS if beam.is_key else _TILT))
        gap = shadowing(places, shadow, noise)
        if beam.is_key:
            shown = KEY_COLOR * (gap <= 0.0)[:, None]
        else:
            frame = np.stack([shadow.right, shadow.up], axis=1)
            shown = room.seen(places, frame @ noise + shadow.towards[:, None])
            hidden = np.flatnonzero(gap > 0.0)
            far = np.sqrt(np.clip((gap[hidden] - _NEAR_M) / np.float32(_FAR_M - _NEAR_M), 0.0, 1.0))
            shown[hidden] = _FIRST_HAND + far[:, None] * (_SECOND_HAND - _FIRST_HAND)
        shown *= (cosine[lit] * np.float32(beam.weight))[:, None]
        self._light[lit] += shown

    def image(self, room: Surroundings) -> Singles:
        """(H, W, 3) of the light, 0 where nothing is seen.

        The ceiling and what stands in for missing walls shine by themselves; they are shown as bright as that.
        """
        is_ceiling = (self._normals[2] < -0.9) & (self._places[2] > room.upper[2] - 0.05)
        self._light[is_ceiling] += _ON_CEILING
        self._light[room.is_on_bare_side(self._places)] += _ON_OPEN_SIDE
        out = np.zeros((self._shape[0] * self._shape[1], 3), dtype=np.float32)
        out[self._at] = self._light
        return out.reshape(*self._shape, 3)


def shadowing(places: Singles, shadow: ShadowMap, tilt: Singles) -> Singles:
    """(N,) how far away, metres, what hides each place stands; 0 where nothing does.

    The first look finds how far off it stands, the second looks as far aside as a soft light does at that distance.

    Args:
        places: (3, N) metres. tilt: (2, N) of the way to the light, along right and up of the map.
    """
    frame = np.stack([shadow.right, shadow.up, shadow.towards])
    x, y, z = frame @ places
    bias = np.float32(1.5 * shadow.pixel)
    first = shadow.above(x, y)
    first -= z
    free = first <= bias
    reach = np.where(free, np.float32(_GUESS_M), np.minimum(first, np.float32(2.0)))
    tilt = tilt * reach
    gap = shadow.above(x + tilt[0], y + tilt[1])
    gap -= z
    # Found beside a place that is lit: it hides it only if it stands that far off.
    gap[(gap <= bias) | (free & (2.0 * gap < reach))] = 0.0
    return gap


def smoothed(light: Singles, surfaces: Surfaces, reach_px: int = 2) -> Singles:
    """(H, W, 3) light, averaged over neighbours that lie in the same plane."""
    for axis in (0, 1):
        total, weight = light.copy(), np.ones(light.shape[:2], dtype=np.float32)
        for step in range(-reach_px, reach_px + 1):
            if step == 0:
                continue
            beside = np.roll(light, step, axis=axis)
            normals, places = np.roll(surfaces.normals, step, axis=axis), np.roll(surfaces.places, step, axis=axis)
            alike = np.einsum("ijk,ijk->ij", normals, surfaces.normals) > 0.95
            off = np.abs(np.einsum("ijk,ijk->ij", places - surfaces.places, surfaces.normals))
            share = (alike & (off < 0.01) & np.roll(surfaces.seen, step, axis=axis)).astype(np.float32)
            total += beside * share[..., None]
            weight += share
        light = total / weight[..., None]
    return light
