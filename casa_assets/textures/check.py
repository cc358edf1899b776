"""Check a texture: seams, flatness, noise and repetition, in the picture as it is laid."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image
from scipy import ndimage

from casa_assets.core.numeric import significant
from casa_assets.model.asset.material import Texture
from casa_assets.model.issue import CheckResult, Issue, Report, Severity, Status
from casa_assets.model.registry.rows import Finish
from casa_assets.textures.distance import TextureDescriptor, closest_pairs, oklab

Picture = npt.NDArray[np.float32]

# One step of an 8-bit picture: below it no border can be seen, whatever stands inside.
_STEP = 1.0 / 255.0
# The border is held against the strongest of this share of columns, as joints may lie on it or inside.
_STRONGEST = 0.01
_BAND = 0.04  # of the side: width of the strips whose mean tone is compared
_OVERLAP = 0.13  # of the side: room for the path of a repair, so that it finds a joint to follow
_SHORTEST = 0.6  # of the side: what a repair leaves at least
_LINES = 2.0  # weight of lines against tones


@dataclass(frozen=True)
class Seam:
    """Steps across the border over steps inside: 1 is a border like any other place, 3 is plainly seen."""

    x: float  # across the left and right edge
    y: float  # across the upper and lower edge

    @property
    def worst(self) -> float:
        """The larger of both."""
        return max(self.x, self.y)


def seam(picture: npt.NDArray[np.floating]) -> Seam:
    """Measure both borders of a picture that repeats: (H, W) or (H, W, C), 0..1, at least 16 px a side."""
    image = np.asarray(picture, dtype=np.float32)
    image = image[..., None] if image.ndim == 2 else image
    return Seam(x=_across(image), y=_across(image.swapaxes(0, 1)))


def jump(picture: npt.NDArray[np.floating]) -> Seam:
    """Steps across both borders over the usual step inside.

    Stricter than `seam`: a joint on the border counts. For (H, W, C) pictures that may not have been made to repeat.
    """
    image = np.asarray(picture, dtype=np.float32)
    found = []
    for view in (image, image.swapaxes(0, 1)):
        steps = np.abs(np.diff(view, axis=1, append=view[:, :1])).mean(axis=(0, 2))
        found.append(float(steps[-1] / max(float(np.median(steps[:-1])), _STEP)))
    return Seam(x=found[0], y=found[1])


def repair(picture: npt.NDArray[np.floating], shown: int | None = None) -> Picture:
    """Make a picture tile: even out its light, cut it where the ends match best, blend both ends.

    picture: (H, W, C), 0..1. shown: number of its channels, the first ones, that are seen: they decide where it is cut,
    and theirs is the light. The others are maps of the same surface, which are cut alike. None: all are seen. Returns
    (h, w, C) float32 0..1 with h, w between 0.6 and 1 of H, W; it tiles in both directions.
    """
    image = np.asarray(picture, dtype=np.float32)
    seen = image.shape[2] if shown is None else shown
    image = np.concatenate([_without_drift(image[..., :seen]), image[..., seen:]], axis=2)
    image = _closed(image, seen, ring=False)
    return np.clip(_closed(image.swapaxes(0, 1), seen, ring=True).swapaxes(0, 1), 0.0, 1.0)


def smooth_part(picture: Picture) -> Picture:
    """The smooth image whose removal makes a picture periodic.

    `picture`: (H, W, C). Returns (H, W, C) float32 of mean 0; `picture` minus it has no jump at its border. Ref: L.
    Moisan, Periodic plus Smooth Image Decomposition, J. Math. Imaging Vis. 39 (2011).
    """
    height, width = picture.shape[:2]
    jump = np.zeros_like(picture, dtype=np.float64)
    jump[0] += picture[0] - picture[-1]
    jump[-1] -= picture[0] - picture[-1]
    jump[:, 0] += picture[:, 0] - picture[:, -1]
    jump[:, -1] -= picture[:, 0] - picture[:, -1]
    rows = 2.0 * np.cos(2.0 * np.pi * np.arange(height) / height)
    cols = 2.0 * np.cos(2.0 * np.pi * np.arange(width) / width)
    laplacian = 4.0 - rows[:, None] - cols[None, :]
    laplacian[0, 0] = 1.0
    spectrum = np.fft.fft2(jump, axes=(0, 1)) / laplacian[..., None]
    spectrum[0, 0] = 0.0
    return np.real(np.fft.ifft2(spectrum, axes=(0, 1))).astype(np.float32)


def _across(image: Picture) -> float:
    """Score of the edge between the last and the first column, fine and broad."""
    width = image.shape[1]
    steps = np.abs(np.diff(image, axis=1, append=image[:, :1])).mean(axis=(0, 2))
    strongest = np.sort(steps[:-1])[-max(3, round(_STRONGEST * len(steps[:-1]))) :].mean()
    fine = steps[-1] / max(float(strongest), _STEP)
    # A drift of light shows no step from pixel to pixel, but the tones of the two ends are far apart.
    band = max(2, round(_BAND * width))
    count = width // band
    means = image[:, : count * band].reshape(image.shape[0], count, band, -1).mean(axis=(0, 2))
    inner = np.abs(np.diff(means, axis=0)).mean(axis=1)
    ends = np.abs(image[:, :band].mean(axis=(0, 1)) - image[:, -band:].mean(axis=(0, 1))).mean()
    broad = ends / max(float(inner.max()), 2.0 * _STEP)
    # One of two dozen such steps may well be the largest without being a fault.
    return float(max(fine, broad / 1.3))


def _without_drift(image: Picture) -> Picture:
    """Even out what is as wide as the picture: vignettes and light from one side."""
    coarse = image[:: max(1, image.shape[0] // 64), :: max(1, image.shape[1] // 64)]
    sigma = 0.2 * min(coarse.shape[:2])
    coarse = ndimage.gaussian_filter(coarse, (sigma, sigma, 0.0), mode="nearest")
    scale = (image.shape[0] / coarse.shape[0], image.shape[1] / coarse.shape[1], 1.0)
    light = ndimage.zoom(coarse, scale, order=1, mode="nearest", grid_mode=True)
    evened = image - 0.7 * (light - light.mean(axis=(0, 1)))
    broad = ndimage.gaussian_filter(evened, (4.0, 4.0, 0.0), mode="nearest")
    return np.asarray(np.clip(evened - smooth_part(broad), 0.0, 1.0), dtype=np.float32)


def _closed(image: Picture, seen: int, ring: bool) -> Picture:
    """Cut columns away at both ends so that they fit, and let the ends overlap along the least visible path.

    `seen`: number of channels that decide. `ring`: rows are periodic, so the path has to end where it began.
    """
    overlap = max(4, round(_OVERLAP * image.shape[1]))
    start, length = _best_cut(image[..., :seen], overlap)
    kept = image[:, start : start + length].copy()
    over = image[:, start + length : start + length + overlap]
    path = _path(((over - kept[:, :overlap])[..., :seen] ** 2).sum(axis=2), ring)
    share = np.clip((np.arange(overlap)[None, :] - path[:, None]) / max(2.0, overlap / 20.0) + 0.5, 0.0, 1.0)
    # The first column has to go on from the last one, and the last of the overlap into the picture.
    ramp = np.arange(overlap) / (overlap - 1.0)
    share = np.clip(share, np.maximum(0.0, 4.0 * ramp - 3.0), np.minimum(1.0, 4.0 * ramp))[..., None]
    kept[:, :overlap] = share * kept[:, :overlap] + (1.0 - share) * over
    return kept.astype(np.float32)


def _best_cut(image: Picture, overlap: int) -> tuple[int, int]:
    """First column and number of columns whose ends look most alike, looked for on a coarse grid."""
    width = image.shape[1]
    # Lines that do not meet are seen before tones that differ: they count for more.
    lines = np.abs(np.diff(image, axis=0, append=image[:1])) + np.abs(np.diff(image, axis=1, append=image[:, :1]))
    lines = ndimage.maximum_filter(lines, (3, 3, 1), mode="nearest")
    # Columns are compared as they are, rows may be thinned: a joint that moves by a pixel is seen.
    rows = np.concatenate([image, _LINES * lines], axis=2)[:: max(1, image.shape[0] // 128)]
    hop = max(1, width // 128)
    shortest = round(_SHORTEST * width)
    best = (np.inf, 0, width - overlap)
    for start in range(0, width - overlap - shortest + 1, 2 * hop):
        left = rows[:, start : start + overlap]
        for length in range(shortest, width - overlap - start + 1, hop):
            right = rows[:, start + length : start + length + overlap]
            cost = float(np.abs(left[:, ::hop] - right[:, ::hop]).mean()) * (1.0 + 0.1 * (width - length) / width)
            if cost < best[0]:
                best = (cost, start, length)
    return best[1], best[2]


def _path(cost: npt.NDArray[np.float32], ring: bool) -> npt.NDArray[np.intp]:
    """Column of the cheapest cut from the first row to the last, one column a row at most.

    Ref: A. Efros, W. Freeman, Image Quilting for Texture Synthesis and Transfer, SIGGRAPH 2001.
    """
    path = _cheapest(cost)
    if not ring:
        return path
    middle = int(path[len(path) // 2])
    fenced = cost.copy()
    columns = np.arange(cost.shape[1])
    for row in (0, -1):
        fenced[row] = np.where(columns == middle, fenced[row], np.float32(1e6))
    return _cheapest(fenced)


def _cheapest(cost: npt.NDArray[np.float32]) -> npt.NDArray[np.intp]:
    rows, columns = cost.shape
    total = cost.astype(np.float64)
    for row in range(1, rows):
        above = np.pad(total[row - 1], 1, constant_values=np.inf)
        total[row] += np.minimum(np.minimum(above[:-2], above[1:-1]), above[2:])
    path = np.empty(rows, dtype=np.intp)
    path[-1] = int(np.argmin(total[-1]))
    for row in range(rows - 2, -1, -1):
        low = max(0, int(path[row + 1]) - 1)
        high = min(columns, int(path[row + 1]) + 2)
        path[row] = low + int(np.argmin(total[row, low:high]))
    return path


Pixels = npt.NDArray[np.uint8]
_SLOWEST = 2  # waves per picture that count as its repeat: one blotch, or two


@dataclass(frozen=True)
class Pictures:
    """The images of a finish, decoded."""

    id: str
    tile_m: tuple[float, float]  # width and height of the picture
    base: Pixels  # (H, W, 3) sRGB
    normal: Pixels  # (h, w, 3)
    rough: Pixels  # (h, w)
    size_bytes: int  # of the three files together


@dataclass(frozen=True)
class TextureCheck:
    """One check of a picture."""

    code: str  # never reused
    title: str
    measure: Callable[[Pictures], float]  # the number that is checked
    limit: str  # key in registry/limits.yaml
    unit: str
    most: bool  # whether the limit is an upper one
    fault: str  # a part of a sentence
    description: str  # `{limit}` is replaced by the number


def pictures_of(finish: Finish) -> Pictures:
    """Decode a finish. Raises ValueError: it lacks one of the three images or the size of its tile."""
    material = finish.material
    base, normal = material.base_color_texture, material.normal_texture
    rough = material.metallic_roughness_texture
    if base is None or normal is None or rough is None or finish.tile_m is None:
        raise ValueError(f"{finish.id} lacks a picture or the size of its tile")
    size_bytes = sum(len(t.png) for t in (base, normal, rough))
    return Pictures(finish.id, finish.tile_m, _decoded(base), _decoded(normal), _decoded(rough)[..., 1], size_bytes)


def check_pictures(pictures: Pictures, limits: Mapping[str, float]) -> Report:
    """Run every check of one finish; `limits`: key to number, as registry/limits.yaml has it."""
    results: list[CheckResult] = []
    issues: list[Issue] = []
    for row in TABLE:
        number, limit = float(row.measure(pictures)), limits[row.limit]
        passed = number <= limit if row.most else number >= limit
        status = Status.PASSED if passed else Status.FAILED
        shown = significant(number, 6)
        results.append(CheckResult(code=row.code, status=status, number=shown, limit=limit, unit=row.unit))
        if not passed:
            side = "above" if row.most else "below"
            message = f"{row.fault}: {shown:g} {row.unit}".rstrip() + f" is {side} {limit:g}"
            issues.append(Issue(code=row.code, severity=Severity.ERROR, pointer=row.limit, message=message))
    return Report(subject=pictures.id, results=tuple(results), issues=tuple(issues))


def check_set(name: str, looks: Mapping[str, TextureDescriptor], limits: Mapping[str, float]) -> Report:
    """Check that a set, such as `wall`, is full, and that no two of its `looks` (by id) are nearly alike."""
    wanted, apart = limits[SET_CHECKS["TEX012"][1]], limits[SET_CHECKS["TEX013"][1]]
    pairs = closest_pairs(looks, most=len(looks))
    close = [p for p in pairs if p[0] <= apart]
    nearest = pairs[0][0] if pairs else None
    enough = Status.PASSED if len(looks) >= wanted else Status.FAILED
    results = (
        CheckResult(code="TEX012", status=enough, number=float(len(looks)), limit=wanted),
        CheckResult(code="TEX013", status=Status.NOT_APPLICABLE, reason="the set has no two pictures", limit=apart)
        if nearest is None
        else CheckResult(
            code="TEX013", status=Status.FAILED if close else Status.PASSED, number=significant(nearest, 6), limit=apart
        ),
    )
    alike = [(f"{a} {b}", f"nearly alike: {d:.2f} <= {apart:g}") for d, a, b in close]
    issues = [Issue(code="TEX013", severity=Severity.ERROR, pointer=p, message=text) for p, text in alike]
    if len(looks) < wanted:
        message = f"the set has {len(looks)} pictures, {wanted:g} are wanted"
        issues.insert(0, Issue(code="TEX012", severity=Severity.ERROR, message=message))
    return Report(subject=name, results=results, issues=tuple(issues))


def _decoded(texture: Texture) -> Pixels:
    with Image.open(io.BytesIO(texture.png)) as image:
        return np.asarray(image.convert("RGB"))


def _clipped(p: Pictures) -> float:
    """Share of pixels that are wholly white or wholly black."""
    white, black = (p.base >= 254).all(axis=2), (p.base <= 1).all(axis=2)
    return float((white | black).mean())


def _contrast(p: Pictures) -> float:
    """Standard deviation of the lightness; relief and changes of gloss count as far as they are seen."""
    light = oklab(p.base[::2, ::2] / np.float64(255))[..., 0]
    shade = p.normal[..., :2].std(axis=(0, 1)) / 127.5
    return float(light.std() + 0.5 * np.hypot(shade[0], shade[1]) + 0.2 * float(p.rough.std() / 255))


def _length(p: Pictures) -> float:
    """Largest error of the length of a normal."""
    vectors = p.normal.astype(np.float64) / 127.5 - 1.0
    return float(np.abs(np.linalg.norm(vectors, axis=2) - 1.0).max())


def _lean(p: Pictures) -> float:
    """Deviation of the mean normal from upright; a periodic relief has none."""
    vectors = p.normal.reshape(-1, 3).astype(np.float64) / 127.5 - 1.0
    mean = vectors.mean(axis=0)
    return float(np.hypot(mean[0], mean[1])) if mean[2] > 0 else 1.0


def _blotch(p: Pictures) -> float:
    """Amplitude in lightness of what has one or two waves in the picture: it shows each repeat from afar."""
    step = max(1, min(p.base.shape[:2]) // 128)
    rows, columns = (n - n % step for n in p.base.shape[:2])
    blocks = p.base[:rows, :columns].reshape(rows // step, step, columns // step, step, 3).mean(axis=(1, 3)) / 255
    light = oklab(blocks)[..., 0]
    power = np.abs(np.fft.fft2(light)) ** 2 / light.size**2
    waves_y, waves_x = (np.fft.fftfreq(size, 1 / size) for size in light.shape)
    waves = np.hypot(waves_y[:, None], waves_x[None, :])
    return float(np.sqrt(power[(waves > 0) & (waves <= _SLOWEST)].sum()))


# fmt: off
TABLE: tuple[TextureCheck, ...] = (
    TextureCheck("TEX001", "Seam at the border",
        lambda p: max(seam(picture / np.float32(255)).worst for picture in (p.base, p.rough)), "texture_seam",
        "", True, "the border shows where the picture repeats",
        "The step across the border of the picture is at most {limit:g} times the strongest steps inside it; paint or "
        "generate it so that it tiles."),
    TextureCheck("TEX002", "Mean brightness", lambda p: float(p.base.mean() / 255), "texture_dark", "", False,
        "the picture is nearly black",
        "The mean colour is at least {limit:g} of white; choose lighter colours."),
    TextureCheck("TEX003", "Clipped pixels", _clipped, "texture_clipped", "", True,
        "pixels are clipped to white or black",
        "At most {limit:.0%} of the pixels are pure white or pure black; lower the contrast or the exposure."),
    TextureCheck("TEX004", "Visible contrast", _contrast, "texture_contrast", "", False,
        "nothing is seen on the picture, a plain finish would do",
        "The standard deviation of what is seen is at least {limit:g}; use a plain finish, or a stronger pattern."),
    TextureCheck("TEX005", "Length of normals", _length, "texture_normal_length", "", True,
        "normals are not of unit length",
        "Normals of the normal map have unit length to {limit:g}; normalise them before they are stored."),
    TextureCheck("TEX006", "Mean of normals", _lean, "texture_normal_lean", "", True,
        "normals lean to one side on the whole",
        "The mean of all normals leans by at most {limit:g} along the surface; take the slope out of the height map."),
    TextureCheck("TEX007", "Least roughness", lambda p: float(np.quantile(p.rough, 0.01) / 255), "texture_rough_low",
        "", False, "the surface is a mirror that renderers alias on",
        "All but one per cent of the surface has a roughness of at least {limit:g}; raise the roughness."),
    TextureCheck("TEX008", "Pixels per metre",
        lambda p: min(p.base.shape[1] / p.tile_m[0], p.base.shape[0] / p.tile_m[1]), "texture_resolution", "px/m",
        False, "the picture is coarse for its size",
        "The picture has at least {limit:g} pixels per metre; use more pixels, or state a smaller size."),
    TextureCheck("TEX009", "Size of the picture", lambda p: min(p.tile_m), "texture_tile_m", "m", False,
        "the picture is small, its repeat is seen",
        "The shorter side of the picture spans at least {limit:g} m of surface; make a larger picture."),
    TextureCheck("TEX010", "Visible repeats", _blotch, "texture_blotch", "", True,
        "one blotch shows every repeat from afar",
        "Lightness varies by at most {limit:g} over half a picture or more; even out large blotches."),
    TextureCheck("TEX011", "File size", lambda p: p.size_bytes / 1e6, "texture_megabytes", "MB", True,
        "the files are large",
        "The three files of a finish have at most {limit:g} MB together; use fewer pixels, or less noise."),
)
# fmt: on
# Checks of a whole set: code -> title, key of the limit, description.
SET_CHECKS = {
    "TEX012": (
        "Size of the set",
        "texture_set_count",
        "The set of a surface (walls, floors, counters, cabinets) has at least {limit:g} pictures; add recipes.",
    ),
    "TEX013": (
        "Distinct pictures",
        "texture_alike",
        "No two pictures of a set are nearer than {limit:g} to each other in looks; change the seed or numbers of one.",
    ),
}
