"""The viewer of pages: the bundle as one script file beside the pages that load it, named by its digest."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from importlib.resources import files
from pathlib import Path


@lru_cache(maxsize=1)
def viewer_script() -> bytes:
    """The bundle: three.js and our source, one classic script that defines `casaViewer`."""
    return files("casa_assets.pipeline.viewer").joinpath("bundle", "viewer.js").read_bytes()


@lru_cache(maxsize=1)
def viewer_name() -> str:
    """File name of the viewer; it holds its digest, so that pages of two versions may lie side by side."""
    return f"viewer_{hashlib.sha256(viewer_script()).hexdigest()[:12]}.js"


def put_viewer(folder: Path) -> str:
    """Write the viewer into a folder where it is missing; returns its file name."""
    target = folder / viewer_name()
    if not target.is_file() or target.stat().st_size != len(viewer_script()):
        folder.mkdir(parents=True, exist_ok=True)
        target.write_bytes(viewer_script())
    return target.name
