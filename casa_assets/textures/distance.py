"""Perceptual distance of textures by colour, size and direction of features, gloss and relief."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import linear_from_srgb_array

Array = npt.NDArray[np.float64]

# At or below this distance two pictures are nearly alike: the same recipe with another seed stays below it, and a
# person shown both as a cabinet front would call it the same finish.
NEARLY_ALIKE = 1.0

_LONGEST_M = 1.28  # the first octave ends here; what is larger depends on the seed
_OCTAVES = 8  # down to 5 mm: pictures of the 128 px that a quick look has show no more
_SECTORS = 4  # along u, the two diagonals, along v
_BINS = 8  # of pixels sorted by lightness; means of bins, for a quantile jumps from one mineral to the next
_TRUST = (0.5, 0.75)  # of the two longest octaves: a picture holds so few of their waves that the seed decides
# A difference of this size in one term alone makes two pictures distinct.
_MEAN_STEP = 0.030  # Oklab; about twice what is just seen on two doors side by side. Ref: Oklab, B. Ottosson (2020)
_SPREAD_STEP = 0.040  # Oklab, of a bin of the lightness
_BAND_STEP = 0.55  # natural log of an amplitude over the floor
_SHAPE_STEP = 1.6  # skew of a band in cube roots
_GLOSS_STEP = 0.14  # roughness
_FLOOR = 0.006  # Oklab lightness: texture of less amplitude is not seen


# Ref: B. Ottosson, A perceptual color space (2020).
_CONES_FROM_RGB = np.array(
    [
        (0.4122214708, 0.2119034982, 0.0883024619),
        (0.5363325363, 0.6806995451, 0.2817188376),
        (0.0514459929, 0.1073969566, 0.6299787005),
    ]
)
_LAB_FROM_CONES = np.array(
    [
        (0.2104542553, 1.9779984951, 0.0259040371),
        (0.7936177850, -2.4285922050, 0.7827717662),
        (-0.0040720468, 0.4505937099, -0.8086757660),
    ]
)


@dataclass(frozen=True)
class TextureDescriptor:
    """Descriptor of one texture. All arrays float64."""

    color: Array  # (3,) mean in Oklab
    tones: Array  # (8,) mean lightness of eighths of the pixels, from the darkest, less the mean of all
    chroma: Array  # (2,) standard deviation of a and b
    bands: Array  # (8, 4) log amplitude of the lightness by octave of wavelength (1.28 m down) and direction of change
    shape: Array  # (8,) cube root of the skew by octave: light lines on dark against dark lines on light
    gloss: Array  # (2,) mean of the roughness, and log amplitude of the slope of the relief

    @cached_property
    def vector(self) -> Array:
        """All terms over their steps, so that the distance of two is the norm of their difference."""
        return np.concatenate(
            [
                self.color / _MEAN_STEP,
                self.tones / (_SPREAD_STEP * np.sqrt(len(self.tones) / 2.0)),
                self.chroma / (_SPREAD_STEP / 2.0),
                self.bands.ravel() / (_BAND_STEP * np.sqrt(self.bands.size / 4.0)),
                self.shape / (_SHAPE_STEP * np.sqrt(len(self.shape) / 2.0)),
                self.gloss / (_GLOSS_STEP, 1.5 * _BAND_STEP),
            ]
        )


def describe_texture(
    albedo: npt.NDArray[np.floating],
    tile_m: tuple[float, float],
    roughness: npt.NDArray[np.floating] | None = None,
    height_m: npt.NDArray[np.floating] | None = None,
) -> TextureDescriptor:
    """Compute the descriptor of a periodic texture.

    `albedo`: (H, W, 3) sRGB 0..1, 128 to 256 px. `roughness`: (H, W) 0..1, `height_m`: (H, W); or None: unknown.
    """
    lab = oklab(albedo)
    mean = lab.mean(axis=(0, 1))
    light = lab[..., 0] - mean[0]
    bands, shape = _spectrum(light, tile_m)
    gloss = 0.5 if roughness is None else float(roughness.mean())
    relief = 0.0 if height_m is None else _slope(np.asarray(height_m, dtype=np.float64), tile_m)
    return TextureDescriptor(
        color=mean,
        tones=np.array([part.mean() for part in np.array_split(np.sort(light, axis=None), _BINS)]),
        chroma=lab[..., 1:].std(axis=(0, 1)),
        bands=bands,
        shape=shape,
        gloss=np.array([gloss, np.log(0.05 + relief)]),
    )


def distance(one: TextureDescriptor, other: TextureDescriptor) -> float:
    """0 for the same, `NEARLY_ALIKE` where two are as alike as two pieces of one material."""
    return float(np.linalg.norm(one.vector - other.vector))


def pairwise(looks: Sequence[TextureDescriptor]) -> Array:
    """(N, N) symmetric distances, 0 on the diagonal."""
    vectors = np.stack([each.vector for each in looks]) if looks else np.zeros((0, 1))
    # Row by row: the differences of all pairs at once would take N times the memory.
    return np.stack([np.linalg.norm(vectors - row, axis=1) for row in vectors]) if looks else np.zeros((0, 0))


def closest_pairs(
    looks: Mapping[str, TextureDescriptor], below: float = np.inf, most: int = 20
) -> tuple[tuple[float, str, str], ...]:
    """(distance, id, id) of the most alike pairs, the closest first; ids of a pair in the order of `looks`."""
    ids = tuple(looks)
    table = pairwise([looks[name] for name in ids])
    rows, columns = np.triu_indices(len(ids), k=1)
    order = np.argsort(table[rows, columns], kind="stable")
    found = [(float(table[rows[i], columns[i]]), ids[rows[i]], ids[columns[i]]) for i in order[: max(most, 0)]]
    return tuple(pair for pair in found if pair[0] <= below)


def oklab(albedo: npt.NDArray[np.floating]) -> Array:
    """(H, W, 3) sRGB 0..1 into Oklab: lightness 0..1, a and b. Ref: B. Ottosson, A perceptual color space (2020)."""
    rgb = np.clip(np.asarray(albedo, dtype=np.float64), 0.0, 1.0)
    return np.asarray(np.cbrt(linear_from_srgb_array(rgb) @ _CONES_FROM_RGB) @ _LAB_FROM_CONES)


def _spectrum(light: Array, tile_m: tuple[float, float]) -> tuple[Array, Array]:
    """Log amplitudes by octave and sector, and the cube root of the skew by octave."""
    height, width = light.shape
    spectrum = np.fft.fft2(light)
    per_m_y = np.fft.fftfreq(height, tile_m[1] / height)[:, None]
    per_m_x = np.fft.fftfreq(width, tile_m[0] / width)[None, :]
    waves = np.hypot(per_m_x, per_m_y)
    octave = np.floor(np.log2(np.maximum(waves, 1e-9) * _LONGEST_M))
    # Half a sector off the axes, so that what is upright or level falls into the middle of one.
    sector = np.floor(np.mod(np.arctan2(per_m_y, per_m_x) / np.pi + 0.5 / _SECTORS, 1.0) * _SECTORS)
    power = np.abs(spectrum) ** 2 / light.size**2
    bands, shape = np.zeros((_OCTAVES, _SECTORS)), np.zeros(_OCTAVES)
    for n in range(_OCTAVES):
        inside = (octave == n) if n else (octave <= 0) & (waves > 0)
        bands[n] = [power[inside & (sector == s)].sum() for s in range(_SECTORS)]
        part = np.real(np.fft.ifft2(spectrum * inside))
        shape[n] = np.cbrt(np.mean(part**3) / (part.std() ** 3 + _FLOOR**3))
    trust = np.append(_TRUST, np.ones(_OCTAVES - len(_TRUST)))
    return np.log(1.0 + np.sqrt(bands) / _FLOOR) * trust[:, None], shape * trust


def _slope(height_m: Array, tile_m: tuple[float, float]) -> float:
    """Root mean square slope, metres a metre."""
    rise_x = (np.roll(height_m, -1, axis=1) - height_m) / (tile_m[0] / height_m.shape[1])
    rise_y = (np.roll(height_m, -1, axis=0) - height_m) / (tile_m[1] / height_m.shape[0])
    return float(np.sqrt(np.mean(rise_x**2 + rise_y**2)))
