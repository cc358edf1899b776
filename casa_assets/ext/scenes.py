"""For exports of kitchens: how kitchens are resolved and built, and what is kept of them."""

from __future__ import annotations

from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.core.system import cache_for, kept_json, replace_file, require
from casa_assets.families.asset_store import AssetStore
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run.kept import is_whole
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.layouts.run.scene_folders import run_recipes, scene_key, work_on_built
from casa_assets.layouts.run.state_file import digest_of_file, read_states, write_states
from casa_assets.projects import read_once
from casa_assets.runs.pool import Workers

__all__ = [
    "AssetStore",
    "build_scene",
    "cache_for",
    "digest_of",
    "digest_of_file",
    "facts_of",
    "is_whole",
    "kept_json",
    "key_of",
    "KitchenRequest",
    "read_once",
    "read_states",
    "replace_file",
    "require",
    "run_recipes",
    "scene_key",
    "SceneRecipe",
    "SceneResult",
    "work_on_built",
    "Workers",
    "write_states",
]
