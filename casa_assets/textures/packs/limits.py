"""Sizes of pictures and files that a pack accepts."""

from __future__ import annotations

MIN_SIDE_PX = 512
MAX_SIDE_PX = 8192
MAX_ASPECT = 2.0  # long side over short side: a longer strip shows too little of a pattern
MAX_FILE_BYTES = 256 * 1024 * 1024
