"""The table of contents of a USD crate file, held against its bytes before the library of USD allocates by it."""

from __future__ import annotations

import struct

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes

MAGIC = b"PXR-USDC"
# A crate has six sections; others may come.
MAX_SECTIONS = 64
# Whole numbers take a quarter of a byte at least, and LZ4 packs 255 to one at most.
ITEMS_PER_BYTE = 4 * 255


def check_crate(data: bytes, name: str) -> None:
    """Look at where the sections of a crate lie, and at how many items each claims. Text layers pass.

    Ref: OpenUSD, pxr/usd/sdf/crateFile.h: magic, version, place of the table; each section begins with its count.

    Raises:
        Rejected: TRUNCATED, LENGTH_MISMATCH.
    """
    if not data.startswith(MAGIC):
        return
    if len(data) < 32:
        raise Rejected(codes.TRUNCATED, f"{name}: {len(data)} bytes, a USD crate has more; fetch it again")
    place = struct.unpack_from("<q", data, 16)[0]
    count = struct.unpack_from("<Q", data, place)[0] if 0 < place <= len(data) - 8 else 0
    if not 0 < count <= MAX_SECTIONS or place + 8 + 32 * count > len(data):
        raise Rejected(codes.TRUNCATED, f"{name}: the USD crate ends before its table of contents; fetch it again")
    for number in range(count):
        label, start, size = struct.unpack_from("<16sqq", data, place + 8 + 32 * number)
        if start < 0 or size < 0 or start + size > len(data):
            raise _mismatch(label, f"lies at byte {start}, past the end", name)
        items = struct.unpack_from("<Q", data, start)[0] if size >= 8 else 0
        if items > ITEMS_PER_BYTE * size:
            raise _mismatch(label, f"claims {items} items in {size} bytes", name)
        if label.startswith(b"TOKENS") and size >= 16:
            unpacked = struct.unpack_from("<Q", data, start + 8)[0]
            if unpacked > ITEMS_PER_BYTE * size:
                raise _mismatch(label, f"claims {unpacked} bytes in {size}", name)


def _mismatch(label: bytes, why: str, name: str) -> Rejected:
    section = label.rstrip(b"\0").decode("ascii", "replace")[:16]
    return Rejected(codes.LENGTH_MISMATCH, f"{name}: the section {section} of the USD crate {why}; fetch it again")
