"""Check one texture for faults, and a set of textures for variety. Codes TEX001 to TEX013."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.numeric import significant
from casa_assets.model.asset.material import Texture
from casa_assets.model.issue import CheckResult, Issue, Report, Severity, Status
from casa_assets.model.registry.rows import Finish
from casa_assets.textures.distance import TextureDescriptor, closest_pairs, oklab
from casa_assets.textures.seam import seam

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
    """Decode a finish.

    Raises:
        ValueError: it lacks one of the three images or the size of its tile.
    """
    material = finish.material
    base, normal = material.base_color_texture, material.normal_texture
    rough = material.metallic_roughness_texture
    if base is None or normal is None or rough is None or finish.tile_m is None:
        raise ValueError(f"{finish.id} lacks a picture or the size of its tile")
    size_bytes = sum(len(t.png) for t in (base, normal, rough))
    return Pictures(finish.id, finish.tile_m, _decoded(base), _decoded(normal), _decoded(rough)[..., 1], size_bytes)


def check_pictures(pictures: Pictures, limits: Mapping[str, float]) -> Report:
    """Run every check of one finish.

    Args:
        pictures: of the finish. limits: key to number, as registry/limits.yaml has it.
    """
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
    """Check a set: its size, and that no two textures are nearly alike.

    Args:
        name: of the set, such as `wall`.
        looks: of every picture of the set, by id. limits: as registry/limits.yaml has it.
    """
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
    issues = [
        Issue(code="TEX013", severity=Severity.ERROR, pointer=f"{a} {b}", message=f"nearly alike: {d:.2f} <= {apart:g}")
        for d, a, b in close
    ]
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
    gloss = float(p.rough.std() / 255)
    return float(light.std() + 0.5 * np.hypot(shade[0], shade[1]) + 0.2 * gloss)


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


TABLE: tuple[TextureCheck, ...] = (
    TextureCheck(
        "TEX001",
        "Seam at the border",
        lambda p: max(seam(picture / np.float32(255)).worst for picture in (p.base, p.rough)),
        "texture_seam",
        "",
        True,
        "the border shows where the picture repeats",
        "The step across the border of the picture is at most {limit:g} times the strongest steps inside it; paint or "
        "generate it so that it tiles.",
    ),
    TextureCheck(
        *("TEX002", "Mean brightness", lambda p: float(p.base.mean() / 255), "texture_dark", "", False),
        "the picture is nearly black",
        "The mean colour is at least {limit:g} of white; choose lighter colours.",
    ),
    TextureCheck(
        *("TEX003", "Clipped pixels", _clipped, "texture_clipped", "", True),
        "pixels are clipped to white or black",
        "At most {limit:.0%} of the pixels are pure white or pure black; lower the contrast or the exposure.",
    ),
    TextureCheck(
        *("TEX004", "Visible contrast", _contrast, "texture_contrast", "", False),
        "nothing is seen on the picture, a plain finish would do",
        "The standard deviation of what is seen is at least {limit:g}; use a plain finish, or a stronger pattern.",
    ),
    TextureCheck(
        *("TEX005", "Length of normals", _length, "texture_normal_length", "", True),
        "normals are not of unit length",
        "Normals of the normal map have unit length to {limit:g}; normalise them before they are stored.",
    ),
    TextureCheck(
        *("TEX006", "Mean of normals", _lean, "texture_normal_lean", "", True),
        "normals lean to one side on the whole",
        "The mean of all normals leans by at most {limit:g} along the surface; take the slope out of the height map.",
    ),
    TextureCheck(
        "TEX007",
        "Least roughness",
        lambda p: float(np.quantile(p.rough, 0.01) / 255),
        "texture_rough_low",
        "",
        False,
        "the surface is a mirror that renderers alias on",
        "All but one per cent of the surface has a roughness of at least {limit:g}; raise the roughness.",
    ),
    TextureCheck(
        "TEX008",
        "Pixels per metre",
        lambda p: min(p.base.shape[1] / p.tile_m[0], p.base.shape[0] / p.tile_m[1]),
        "texture_resolution",
        "px/m",
        False,
        "the picture is coarse for its size",
        "The picture has at least {limit:g} pixels per metre; use more pixels, or state a smaller size.",
    ),
    TextureCheck(
        *("TEX009", "Size of the picture", lambda p: min(p.tile_m), "texture_tile_m", "m", False),
        "the picture is small, its repeat is seen",
        "The shorter side of the picture spans at least {limit:g} m of surface; make a larger picture.",
    ),
    TextureCheck(
        *("TEX010", "Visible repeats", _blotch, "texture_blotch", "", True),
        "one blotch shows every repeat from afar",
        "Lightness varies by at most {limit:g} over half a picture or more; even out large blotches.",
    ),
    TextureCheck(
        *("TEX011", "File size", lambda p: p.size_bytes / 1e6, "texture_megabytes", "MB", True),
        "the files are large",
        "The three files of a finish have at most {limit:g} MB together; use fewer pixels, or less noise.",
    ),
)
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
