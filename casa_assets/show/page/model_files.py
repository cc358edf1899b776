"""Files with which pages show models in 3D: the viewer as one script file next to them, and a script file per model.

Pages are opened from disk, where a browser refuses to fetch files. So a model comes as `<name>.glb.js`, which hands
over its GLB; it is loaded on demand, as the viewer is. A model does not depend on the viewer, so that a change of the
viewer does not require models to be made again. The template `model.html` says how a page uses them.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from casa_assets.core.system import process_name

SUFFIX = ".glb.js"


@lru_cache(maxsize=1)
def viewer_script() -> bytes:
    """The bundle: three.js and our source, one classic script that defines `casaViewer`."""
    return files("casa_assets.show.page").joinpath("bundle", "viewer.js").read_bytes()


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


@dataclass(frozen=True)
class ModelFiles:
    """Names and paths that a page needs to show a model.

    Attributes:
        name: of the model. script: path of its script file, and viewer: of the viewer, both relative to the page.
    """

    name: str
    script: str
    viewer: str


def model_script(name: str, glb: bytes) -> bytes:
    """Content of the script file of a model; the same GLB is the same bytes.

    Args:
        name: letters, digits, `_`, `-`, such as the id of an asset.
    """
    packed = base64.b64encode(gzip.compress(glb, 9, mtime=0)).decode("ascii")
    return f'casaModel("{name}","{packed}");\n'.encode("ascii")


def put_model(folder: Path, name: str, glb: bytes) -> str:
    """Write `<name>.glb.js` into a folder, put in place by one rename; returns its file name."""
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"{name}{SUFFIX}"
    fresh = folder / f".{target.name}.{process_name()}"
    fresh.write_bytes(model_script(name, glb))
    fresh.replace(target)
    return target.name
