"""Check that shards are of one run of this version of the program, and that all of them are there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.ingest.shards.record import ShardRecord, made_by

# What all shards of one run have in common, and what to say where they do not.
COMMON = {
    "count": "is one of another number of shards",
    "category": "was made with another --category",
    "split": "was made with another --split",
    "keep_duplicates": "was made with another --keep-duplicates",
    "limits": "was made with other limits on inputs",
    "cache_key": "was made by another version of casa-assets",
    "made_by": "was made by another version of casa-assets",
    "inputs_digest": "found other inputs, because the sources have changed in between,",
}
# Missing shards that are named.
MAX_NAMED = 8


def check_shards(records: Sequence[ShardRecord], cache_key: str, is_partial: bool) -> None:
    """Check that shards may be merged.

    Args:
        cache_key: of a run of this program with their options. is_partial: some may be missing.
    Raises:
        OutputError: they are not of one run, one is there twice or missing, or another version made them.
    """
    first = records[0]
    seen: dict[int, Path] = {}
    for record in records:
        root, header = record.library.root, record.header
        for name, words in COMMON.items():
            if getattr(header, name) != getattr(first.header, name):
                message = f"{words} than {first.library.root}; run all shards again, with the same options"
                raise OutputError(str(root), message)
        if header.index in seen:
            raise OutputError(str(root), f"holds shard {header.shard}, as {seen[header.index]} does; name one of them")
        seen[header.index] = root
    if (first.header.cache_key, first.header.made_by) != (cache_key, made_by()):
        message = "was made by another version of casa-assets; merge with that one, or run all shards again"
        raise OutputError(str(first.library.root), message)
    _check_complete(records, is_partial)


def _check_complete(records: Sequence[ShardRecord], is_partial: bool) -> None:
    header, root = records[0].header, str(records[0].library.root)
    missing = sorted(set(range(1, header.count + 1)) - {record.header.index for record in records})
    if missing and not is_partial:
        few = ", ".join(f"{index}/{header.count}" for index in missing[:MAX_NAMED])
        more = f" and {len(missing) - MAX_NAMED} more" if len(missing) > MAX_NAMED else ""
        message = f"is one of {header.count} shards, and these are missing: {few}{more}; name them too, or --partial"
        raise OutputError(root, message)
    lines = [line for record in records for line in record.lines]
    numbers = {line.number for line in lines if line.source is not None}
    rows = sum(sum(line.refused.counts.values()) for line in lines if line.refused is not None)
    count = sum(line.source is not None for line in lines)
    if count != len(numbers) or (not missing and count + rows != header.inputs):
        raise OutputError(root, f"the shards hold {count + rows} of {header.inputs} inputs; run all of them again")
