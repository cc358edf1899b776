"""Makes one of our kitchens once more with what an earlier run painted and cooked at hand, and tells the seconds.

    python ours.py SCENE FOLDER

FOLDER is where it was built before. Prints one JSON object.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from casa_assets.model.issue import Files


def main() -> None:
    """Resolve, build and write, and tell the seconds."""
    begin = time.perf_counter()
    from casa_assets.asset.lightweight import light_scene
    from casa_assets.families.asset_store import AssetStore
    from casa_assets.formats.mjcf import kitchen as mjcf
    from casa_assets.formats.usd import kitchen as usd
    from casa_assets.layouts.run.recipe import SceneRecipe
    from casa_assets.layouts.run.resolve import build_scene, resolve
    from casa_assets.library.library import Library

    imported = time.perf_counter()
    plan, style = sys.argv[1].split("__")
    recipe = SceneRecipe(plan, style)
    resolve(recipe)
    resolved = time.perf_counter()
    cache = Library(Path(sys.argv[2])).cache
    _, scene = build_scene(recipe, cache)
    built = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        full_s = written(lambda: mjcf.write(scene), Path(folder) / "mjcf")
        usd_s = written(lambda: usd.write(scene), Path(folder) / "usd")
        form = AssetStore(cache).lightened
        light_s = written(lambda: mjcf.write(light_scene(scene, form)), Path(folder) / "light")
    # The build resolves once more by itself.
    seconds = {"import_s": imported - begin, "generate_s": built - resolved}
    print(json.dumps({**seconds, "mjcf_s": full_s, "usd_s": usd_s, "light_s": light_s}))


def written(make: Callable[[], Files], folder: Path) -> float:
    """Seconds to make files and put them on disk."""
    begin = time.perf_counter()
    for path, data in make().entries.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)
    return time.perf_counter() - begin


if __name__ == "__main__":
    main()
