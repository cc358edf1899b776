"""Keep where the code of a plug-in failed.

Jobs import this module alone: the modules that run batches import engines, and which engine is installed is no part of
what a result depends on.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from casa_assets.errors import PluginFailure
from casa_assets.pipeline.library.library import Library

TRACES = "traces"  # folder in the cache of a library


def keep_trace(error: PluginFailure, library: Library) -> Path:
    """Write where code of a plug-in has failed into a file of a library, called after its text; the file."""
    folder = library.cache / TRACES
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{error.plugin}_{hashlib.sha256(error.trace.encode()).hexdigest()[:10]}.txt"
    path.write_text(error.trace, encoding="utf-8")
    return path
