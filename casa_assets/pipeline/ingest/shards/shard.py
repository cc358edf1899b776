"""Tell the inputs of a shard by the names of their files alone, so that machines have nothing to agree on."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass

from casa_assets.errors import CasaError
from casa_assets.ingest.sources.bounded_reads import utf8_escaped
from casa_assets.ingest.sources.found import Found, Refused


@dataclass(frozen=True)
class Shard:
    """One of the parts that the inputs of a run are divided into.

    Attributes:
        index: 1 to count.
    """

    index: int
    count: int

    def __str__(self) -> str:
        """Text such as `3/16`."""
        return f"{self.index}/{self.count}"

    @classmethod
    def parse(cls, text: str) -> Shard:
        """The shard that a text such as `3/16` names. Raises CasaError."""
        match = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
        shard = cls(int(match[1]), int(match[2])) if match else None
        if shard is None or not 1 <= shard.index <= shard.count:
            raise CasaError(f"{text!r} is no shard; give i/n with i from 1 to n, such as 3/16: the third of sixteen")
        return shard

    def has(self, one: Found | Refused) -> bool:
        """True if this is the shard of an input."""
        return index_of(file_of(one), self.count) == self.index


def index_of(path: str, count: int) -> int:
    """Index of the shard of a file, 1 to `count`: by the sha256 of its path, so other files do not change it.

    Args:
        path: as its source calls it.
    """
    return int.from_bytes(hashlib.sha256(path.encode()).digest()[:8], "big") % count + 1


def file_of(one: Found | Refused) -> str:
    """Path, as its source calls it, of the file on the disk that an input stands in: of a member, its archive."""
    if isinstance(one, Refused):
        return one.path
    return one.source.path.removesuffix(f"!{utf8_escaped(one.main)}") if one.archive else one.source.path
