"""Find pairs of assets with the same surface: candidates by signature, confirmed by registering one onto the other."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.checks.library.duplicates import ShapePair
from casa_assets.geometry.mesh.registration import SampledSurface, align, sampled_surface
from casa_assets.geometry.mesh.shape_descriptor import descriptor_distance
from casa_assets.model.asset.signature import CENTER_SHARES, PAIR_SHARES, ShapeDescriptor
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.dedup.entries import AssetRow
from casa_assets.pipeline.dedup.signature import surface
from casa_assets.pipeline.library import library as disk
from casa_assets.preview.color_statistics import color_distance

# Shapes whose descriptors differ by more than this are not registered, see benchmarks/ingest_duplicates.py.
MAX_DESCRIPTOR_DISTANCE = 0.035


def similar_pairs(rows: Sequence[AssetRow], store: Store) -> Iterator[ShapePair]:
    """Every pair of assets with similar shape descriptors, measured, in the order of the rows.

    Args:
        store: keeps what was measured, by the contents of both.
    """
    rows_with_shape = [row for row in rows if row.signature is not None]
    for i, j in nearby_pairs([row.signature.shape for row in rows_with_shape if row.signature is not None]):
        yield measure_pair(rows_with_shape[i], rows_with_shape[j], store)


class ShapeIndex:
    """Shape descriptors as one array, in which the few that are similar to a given one are found quickly."""

    def __init__(self, forms: Iterable[ShapeDescriptor] = ()) -> None:
        self._forms = list(forms)
        self._table = np.array([_flat(form) for form in self._forms]).reshape(-1, PAIR_SHARES + CENTER_SHARES + 3)

    def add(self, form: ShapeDescriptor) -> None:
        """One more form; its place is the number of those before it."""
        count = len(self._forms)
        if count == len(self._table):
            room = np.zeros((max(64, count), self._table.shape[1]))
            self._table = np.concatenate((self._table, room))
        self._table[count] = _flat(form)
        self._forms.append(form)

    def near(self, form: ShapeDescriptor) -> list[int]:
        """Places of the forms that are near a form, ascending."""
        differences = np.abs(self._table[: len(self._forms)] - np.array(_flat(form)))
        pairs, radii = differences[:, :PAIR_SHARES].mean(axis=1), differences[:, PAIR_SHARES:-3].mean(axis=1)
        distance = np.maximum(np.maximum(pairs, radii), differences[:, -3:].max(axis=1))
        # These sums are in another order and may differ in the last digits, so `descriptor_distance` decides.
        candidates = np.flatnonzero(distance <= MAX_DESCRIPTOR_DISTANCE * (1 + 1e-9)).tolist()
        return [i for i in candidates if descriptor_distance(form, self._forms[i]) <= MAX_DESCRIPTOR_DISTANCE]


def _flat(form: ShapeDescriptor) -> tuple[float, ...]:
    return (*form.pair_distances, *form.center_distances, *form.axis_spread)


def nearby_pairs(forms: Sequence[ShapeDescriptor]) -> list[tuple[int, int]]:
    """Indices of the pairs of forms that are near each other, in order."""
    if len(forms) < 2:
        return []
    table = np.array([form.pair_distances for form in forms])
    found = cKDTree(table).query_pairs(MAX_DESCRIPTOR_DISTANCE * PAIR_SHARES, p=1)
    return sorted((i, j) for i, j in found if descriptor_distance(forms[i], forms[j]) <= MAX_DESCRIPTOR_DISTANCE)


def measure_pair(one: AssetRow, other: AssetRow, store: Store) -> ShapePair:
    """Measure the similarity of two assets with signatures. Raises OutputError where a file of theirs is damaged."""
    assert one.signature is not None
    assert other.signature is not None
    most, every = _registration_error(one, other, store)
    tints = one.signature.color, other.signature.color
    return ShapePair(
        one=one.id,
        other=other.id,
        most=most,
        every=every,
        size=other.signature.shape.radius / one.signature.shape.radius,
        # If neither asset has a stated colour, colours do not tell them apart.
        colors=color_distance(*tints) if tints[0].stated or tints[1].stated else 0.0,
        same_category=one.category == other.category,
    )


def _registration_error(one: AssetRow, other: AssetRow, store: Store) -> tuple[float, float]:
    key = digest_of("overlay", key_of(align, sampled_surface, surface), one.digest, other.digest)
    kept = store.get(key)
    if kept is not None:
        most, every = json.loads(kept)
        return float(most), float(every)
    found = align(_cloud(one.folder, one.digest), _cloud(other.folder, other.digest))
    with suppress(OSError):  # a library that may only be read
        store.put(key, json.dumps([found.most, found.all]).encode())
    return found.most, found.all


@lru_cache(maxsize=32)
def _cloud(folder: Path, digest: str) -> SampledSurface:
    """The surface of the asset in a folder; the digest tells what stood there before from what stands there now."""
    return sampled_surface(*surface(disk.read_asset(folder)))
