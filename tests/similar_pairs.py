"""Every pair of similar assets, found at once: what the table of entries has to agree with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from casa_assets.checks.library import ShapePair
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.dedup.pairs import AssetRow, measure_pair, nearby_pairs


def similar_pairs(rows: Sequence[AssetRow], store: Store) -> Iterator[ShapePair]:
    """Every pair of assets with similar shape descriptors, measured, in the order of the rows.

    Args:
        store: keeps what was measured, by the contents of both.
    """
    rows_with_shape = [row for row in rows if row.signature is not None]
    for i, j in nearby_pairs([row.signature.shape for row in rows_with_shape if row.signature is not None]):
        yield measure_pair(rows_with_shape[i], rows_with_shape[j], store)
