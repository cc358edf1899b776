"""Bundle -> RawModel: pure readers, bytes in and records out."""

from __future__ import annotations

from casa_assets.formats.read.dispatch import load

__all__ = ["load"]
