"""Find a kitchen that is there as today's code would make it, without loading what makes it.

To work out the key of a kitchen, all families, plans and styles are loaded, which takes seconds. So the key is
remembered in the cache folder, as long as no file of the program, its registry or the project changes.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import recall, remember
from casa_assets.core.system import kept_json
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.model.kitchen.files import OVERVIEW, SCENE_JSON, WRITTEN

KITCHEN_KEY = "kitchen key"
# By name, so that nothing is imported for a key.
WRITTEN_BY = (
    "casa_assets.layouts.run.scene_folders:write_scene",
    "casa_assets.layouts.run.scene_json:describe",
    "casa_assets.asset.lightweight:lighten",
)
DRAWN_BY = "casa_assets.layouts.run.scene_folders:draw_cameras"


def kept_scene(recipe: SceneRecipe, out: Path, drawn: bool) -> SceneResult | None:
    """The scene that an earlier run made, if that is known to be current without loading anything; else None.

    `out`: folder of the scenes. `drawn`: it has to have an overview.
    """
    known, folder = remembered_kitchen_key(recipe), out / recipe.scene_id
    if not known or not is_whole(folder, key := written_key(known)) or (drawn and not is_drawn(folder, key)):
        return None
    return SceneResult(recipe, str(folder), kept=True)


def remembered_kitchen_key(recipe: SceneRecipe) -> str:
    """The key of a kitchen, if it was worked out since anything changed; else empty."""
    found = recall(KITCHEN_KEY, repr(recipe))
    return found if isinstance(found, str) else ""


def remember_kitchen_key(recipe: SceneRecipe, key: str) -> None:
    """Remember the key of a kitchen of which every asset is built from numbers."""
    remember(key, KITCHEN_KEY, repr(recipe))


def written_key(kitchen_key: str) -> str:
    """Key of the files of a scene, from the key of its kitchen."""
    return digest_of("scene", kitchen_key, key_of(*WRITTEN_BY))


def picture_key(key: str) -> str:
    """Key of the pictures of a scene, from the key of its files."""
    return digest_of("pictures", key, key_of(DRAWN_BY))


def is_whole(folder: Path, key: str) -> bool:
    """True if the files of a scene are all there, under that key."""
    return all((folder / name).is_file() for name in WRITTEN) and _scene_json_field(folder, "key") == key


def is_drawn(folder: Path, key: str) -> bool:
    """True if the overview of a scene is there as today's code draws it. `key`: of the scene's files."""
    return (folder / f"{OVERVIEW}.png").is_file() and _scene_json_field(folder, "picture_key") == picture_key(key)


def _scene_json_field(folder: Path, name: str) -> Any:
    """Return a member of scene.json, or None if it is missing or the file cannot be read."""
    facts = kept_json(folder / SCENE_JSON)
    return facts.get(name) if isinstance(facts, dict) else None
