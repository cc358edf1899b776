"""Bytes of a text file -> plain UTF-8 lines: byte order marks, UTF-16 and foreign line ends are dealt with here."""

from __future__ import annotations

import codecs

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes


def normalize_text(data: bytes, name: str) -> bytes:
    """UTF-8 without byte order mark, lines ended by a single newline.

    Raises:
        Rejected: ENCODING where the bytes are no text (NUL bytes) or broken UTF-16.
    """
    if data.startswith(codecs.BOM_UTF8):
        data = data[3:]
    elif data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            data = data.decode("utf-16").encode("utf-8")
        except UnicodeError as error:
            raise Rejected(codes.ENCODING, f"{name}: broken UTF-16 ({error.args[-1]}); save it as UTF-8") from error
    elif b"\0" in data[:4096]:
        raise Rejected(codes.ENCODING, f"{name}: holds NUL bytes, so it is no text file; save it as UTF-8 text")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data


def decode(raw: bytes) -> str:
    """Text of a short byte string: UTF-8, or Windows-1252 where it is not UTF-8."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")
