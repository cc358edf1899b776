"""CLIP embeddings of a library's pictures, kept by content, and the categories and pairs that follow from them."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.checks.library import NAMED, CategoryRank
from casa_assets.core.numeric import Floats
from casa_assets.library.analysis.clip import ClipModel, class_shares, render_model_views
from casa_assets.library.entry_files import checked_model
from casa_assets.library.table.pairs import AssetRow
from casa_assets.model.registry.category import clip_prompts

# Smallest cosine between the pictures of a pair that is reported; the limit of the check is stricter.
MIN_COSINE = 0.9


def image_embeddings(row: AssetRow, eye: ClipModel, store: Store) -> Floats:
    """(V, D) unit embeddings of the pictures of an asset; taken from the store if they are there.

    Raises:
        CannotDraw, NoRenderer: see preview.still.
    """
    words = ["pictures", key_of(render_model_views), eye.weights_digest, row.digest]
    return _cached(store, words, lambda: eye.encode_images(render_model_views(checked_model(row.folder / "model.xml"))))


def text_embedding(phrases: Sequence[str], eye: ClipModel, store: Store) -> Floats:
    """(D,) mean embedding of several phrases, of length 1."""
    found = _cached(store, ["words", eye.weights_digest, *phrases], lambda: eye.encode_text(phrases))
    mean: Floats = found.mean(axis=0)
    return mean / float(np.linalg.norm(mean))


def likenesses(
    seen: Mapping[str, Floats], rows: Sequence[AssetRow], eye: ClipModel, store: Store
) -> Iterator[CategoryRank]:
    """Rank the categories of the registry by how well they fit the pictures of each asset.

    Args:
        seen: id -> (V, D) numbers of its pictures. rows: the assets.
    """
    if not rows:
        return
    categories = [category for category in registry.load().categories.values() if category.id != registry.FALLBACK]
    text_embeddings = np.array([text_embedding(clip_prompts(category), eye, store) for category in categories])
    for row in rows:
        shares = class_shares(seen[row.id], text_embeddings, eye.logit_scale).tolist()
        both = sorted(zip(shares, categories, strict=True), key=lambda one: (-one[0], one[1].id))
        ranked = [(category.id, round(share, 4)) for share, category in both]
        rank = next((n for n, (name, _) in enumerate(ranked, start=1) if name == row.category), 0)
        others = tuple(one for one in ranked if one[0] != row.category)[:NAMED]
        yield CategoryRank(row.id, row.category, ranked[rank - 1][1] if rank else 0.0, rank, others)


def similar_looking_pairs(seen: Mapping[str, Floats], min_cosine: float = MIN_COSINE) -> list[tuple[str, str, float]]:
    """Pairs of ids with the cosine between their mean embeddings, if that is at least `min_cosine`, nearest first."""
    names = list(seen)
    if len(names) < 2:
        return []
    means = np.array([seen[name].mean(axis=0) for name in names])
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    pairs = []
    for i in range(len(names) - 1):
        cosines = means[i + 1 :] @ means[i]
        pairs += [
            (names[i], names[i + 1 + int(j)], round(float(cosines[j]), 4))
            for j in np.flatnonzero(cosines >= min_cosine)
        ]
    return sorted(pairs, key=lambda pair: (-pair[2], pair[0], pair[1]))


def _cached(store: Store, key_parts: Sequence[object], compute: Callable[[], Floats]) -> Floats:
    key = digest_of(*key_parts)
    stored = store.get(key)
    if stored is not None:
        return np.asarray(np.load(io.BytesIO(stored), allow_pickle=False), dtype=np.float64)
    values = compute()
    out = io.BytesIO()
    np.save(out, values.astype(np.float32), allow_pickle=False)
    with suppress(OSError):  # a library that may only be read
        store.put(key, out.getvalue())
    return values.astype(np.float32).astype(np.float64)
