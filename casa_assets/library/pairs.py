"""Find pairs of assets with the same surface: candidates by shape and colours, confirmed by registration."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.checks.library import ShapePair
from casa_assets.core.numeric import Floats, Ints, decimals, linear_from_srgb_array
from casa_assets.errors import DegenerateShape
from casa_assets.library.entry_files import Manifest, Producer, read_asset, read_manifest
from casa_assets.library.library import Library
from casa_assets.mesh.registration import descriptor_distance, quantile_means, shape_descriptor
from casa_assets.mesh.solid.deviation import barycentric_samples
from casa_assets.mesh.surface import face_normals
from casa_assets.model.asset.asset import (
    CENTER_SHARES,
    PAIR_SHARES,
    TONE_SHARES,
    Asset,
    ColorHistogram,
    ShapeDescriptor,
    Signature,
    Visual,
)
from casa_assets.model.asset.material import Material
from casa_assets.model.record import Vec3

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

    from casa_assets.mesh.registration import SampledSurface

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

# Signature ------------------------------------------------------------------------------------------------------------


def signature(asset: Asset) -> Signature | None:
    """Return the shape and colours of all visible geometry of an asset, joints at zero; None if nothing has an area."""
    try:
        return Signature(shape=shape_descriptor(*surface(asset)), color=color_histogram(asset))
    except DegenerateShape:
        return None


def surface(asset: Asset) -> tuple[Floats, Ints]:
    """(P, 3) points and (F, 3) faces of all that is seen of an asset, asset frame, joints at zero, metres."""
    points, faces, start = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            points.append(pose.apply(visual.mesh.vertices))
            faces.append(visual.mesh.faces.astype(np.int64) + start)
            start += len(visual.mesh.vertices)
    return np.concatenate(points), np.concatenate(faces)


# Entries --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class AssetRow:
    """One accepted asset.

    Attributes:
        id, category: of the asset. folder: of its entry. path, sha256: of its source.
        digest: of the asset with its meshes and pictures. extents: of its bounding box, metres.
        signature: None if it has no visible geometry. from_numbers: a family built it.
    """

    id: str
    category: str
    folder: Path
    path: str
    sha256: str
    digest: str
    extents: Vec3
    signature: Signature | None
    from_numbers: bool = False

    @property
    def longest(self) -> float:
        """Longest side of the box around it, metres."""
        return max(self.extents)


def read_rows(library: Library) -> Iterator[AssetRow]:
    """Every accepted asset, sorted by category and id. Raises OutputError where one is damaged."""
    for folder in library.accepted():
        yield read_row(folder)


def read_row(folder: Path) -> AssetRow:
    """Return the row of the asset in a folder. Raises OutputError if it is damaged."""
    return row_of(read_manifest(folder))


def row_of(manifest: Manifest) -> AssetRow:
    """The asset of a manifest that was read."""
    folder, certificate = manifest.folder, manifest.certificate
    origin = manifest.asset.get("provenance", {})
    return AssetRow(
        id=folder.name,
        category=folder.parent.name,
        folder=folder,
        path=str(origin.get("path", "")),
        sha256=str(origin.get("sha256", "")),
        digest=certificate.asset_digest,
        extents=certificate.summary.extents,
        signature=certificate.signature,
        from_numbers=certificate.producer is Producer.FAMILY,
    )


# Pairs ----------------------------------------------------------------------------------------------------------------

# Shapes whose descriptors differ by more than this are not registered.
MAX_DESCRIPTOR_DISTANCE = 0.035
REGISTRATION = "casa_assets.mesh.registration"
# Numbers of a point of the index, and by how much those of similar descriptors may differ, with something for the last
# digits of sums.
POINT_NUMBERS, POINT_DISTANCE = 5, MAX_DESCRIPTOR_DISTANCE * (1 + 1e-9)
# Points that no tree holds: so many, or this share of the others; choices for speed.
MOST_OUTSIDE, NEWEST_SHARE = 2000, 0.25


class ShapeIndex:
    """Shape descriptors, added one by one, with a fast search for the few that are similar to a given one.

    Each is reduced to a point of few numbers; the largest difference of two points is at most the distance of their
    descriptors. Most points are in a k-d tree; the newest, which are not in the tree yet, are searched linearly. The
    tree is built again whenever there are too many of these.
    """

    def __init__(self, descriptors: Iterable[ShapeDescriptor] = ()) -> None:
        self._descriptors = list(descriptors)
        self._points = np.array([_point(descriptor) for descriptor in self._descriptors]).reshape(-1, POINT_NUMBERS)
        self._tree: cKDTree | None = None
        self._in_tree = 0

    def add(self, descriptor: ShapeDescriptor) -> None:
        """Add one more descriptor; its place is the number of those before it."""
        count = len(self._descriptors)
        if count == len(self._points):
            spare_rows = np.zeros((max(64, count), POINT_NUMBERS))
            self._points = np.concatenate((self._points, spare_rows))
        self._points[count] = _point(descriptor)
        self._descriptors.append(descriptor)

    def near(self, descriptor: ShapeDescriptor) -> list[int]:
        """Places of the descriptors that are near a given one, ascending."""
        count = len(self._descriptors)
        if count - self._in_tree > max(MOST_OUTSIDE, NEWEST_SHARE * self._in_tree):
            from scipy.spatial import cKDTree

            self._tree, self._in_tree = cKDTree(self._points[:count]), count
        point = np.array(_point(descriptor))
        newest = np.abs(self._points[self._in_tree : count] - point).max(axis=1, initial=0.0)
        candidates = (self._in_tree + np.flatnonzero(newest <= POINT_DISTANCE)).tolist()
        if self._tree is not None:
            candidates = sorted(self._tree.query_ball_point(point, POINT_DISTANCE, p=np.inf)) + candidates
        return [
            i for i in candidates if descriptor_distance(descriptor, self._descriptors[i]) <= MAX_DESCRIPTOR_DISTANCE
        ]


def _point(descriptor: ShapeDescriptor) -> tuple[float, ...]:
    """Axes, and means of the other numbers, no two of which differ by more than the distance of the descriptors."""
    pairs, reach = descriptor.pair_distances, descriptor.center_distances
    return (*descriptor.axis_spread, sum(pairs) / PAIR_SHARES, sum(reach) / CENTER_SHARES)


def nearby_pairs(descriptors: Sequence[ShapeDescriptor]) -> list[tuple[int, int]]:
    """Indices of the pairs of descriptors that are near each other, in order."""
    if len(descriptors) < 2:
        return []
    from scipy.spatial import cKDTree

    table = np.array([descriptor.pair_distances for descriptor in descriptors])
    found = cKDTree(table).query_pairs(MAX_DESCRIPTOR_DISTANCE * PAIR_SHARES, p=1)
    return sorted(
        (i, j) for i, j in found if descriptor_distance(descriptors[i], descriptors[j]) <= MAX_DESCRIPTOR_DISTANCE
    )


def measure_pair(one: AssetRow, other: AssetRow, store: Store) -> ShapePair:
    """Measure the similarity of two assets with signatures. Raises OutputError where a file of theirs is damaged."""
    assert one.signature is not None
    assert other.signature is not None
    p95, p995 = _registration_error(one, other, store)
    histograms = one.signature.color, other.signature.color
    return ShapePair(
        one=one.id,
        other=other.id,
        p95=p95,
        p995=p995,
        size=other.signature.shape.radius / one.signature.shape.radius,
        # If neither asset has a stated colour, colours do not tell them apart.
        colors=color_distance(*histograms) if histograms[0].stated or histograms[1].stated else 0.0,
        same_category=one.category == other.category,
    )


def _registration_error(one: AssetRow, other: AssetRow, store: Store) -> tuple[float, float]:
    """The 95th and 99.5th percentile of the distance of the aligned surfaces, from the store or measured now."""
    key = digest_of("overlay", key_of(REGISTRATION, surface), one.digest, other.digest)
    kept = store.get(key)
    if kept is not None:
        p95, p995 = json.loads(kept)
        return float(p95), float(p995)
    from casa_assets.mesh.registration import align

    found = align(_cloud(one.folder, one.digest), _cloud(other.folder, other.digest))
    with suppress(OSError):  # a library that may only be read
        store.put(key, json.dumps([found.p95, found.p995]).encode())
    return found.p95, found.p995


@lru_cache(maxsize=32)
def _cloud(folder: Path, digest: str) -> SampledSurface:
    """Return the sampled surface of the asset in a folder; `digest` is part of the key of the `lru_cache`."""
    from casa_assets.mesh.registration import sampled_surface

    return sampled_surface(*surface(read_asset(folder)))


# Colours --------------------------------------------------------------------------------------------------------------


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
