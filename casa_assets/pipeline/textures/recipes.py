"""Recipes of textures from the registry, and the finishes that are painted from them, kept in the cache."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from casa_assets import registry
from casa_assets.errors import UnknownId
from casa_assets.model.registry.document import Document
from casa_assets.model.registry.finish import Finish, Surface
from casa_assets.model.registry.texture_recipe import TextureRecipe
from casa_assets.pipeline.cache.cache_folder import max_cache_bytes
from casa_assets.pipeline.cache.cache_key import digest_of, key_of, modules_holding
from casa_assets.pipeline.cache.store import Store
from casa_assets.projects import read_once
from casa_assets.registry.layered import names_in, read_table_file
from casa_assets.registry.project import origin_of_row
from casa_assets.textures import kinds
from casa_assets.textures.finish import finish
from casa_assets.textures.kinds import KINDS
from casa_assets.textures.make import SIZE_PX, kind_of, make, paint

FOLDER = "textures"  # of the registry, and within a cache
SKINS = "skins"  # of the registry
SKIN_PX = 384  # longer side of the picture of an object
CACHE_SHARE = 0.5  # part of the bound of a cache that finishes may take


@read_once
def recipes(root: Path | None = None) -> Mapping[Surface, Mapping[str, TextureRecipe]]:
    """All recipes by surface and id.

    Args:
        root: the only folder to read; None reads the package's and the project's.
    Raises:
        RegistryError: a file is missing, or a row names an unknown key, kind or substance, or an id occurs twice.
    """
    substances = _known(root).substances
    found: dict[Surface, Mapping[str, TextureRecipe]] = {}
    taken: dict[str, str] = {}
    for surface in Surface:
        document = read_table_file(f"{FOLDER}/{surface.value}.yaml", root)
        if not isinstance(document.value, dict):
            raise document.fault((), "a mapping of ids to recipes", type(document.value).__name__)
        rows: dict[str, TextureRecipe] = {}
        for name, stated in document.value.items():
            if name in taken:
                raise document.fault((name,), "an id that no other surface has", f"{name!r}, also in {taken[name]}")
            taken[name] = document.file
            rows[name] = _recipe(document, name, stated, surface)
            if rows[name].substance not in substances:
                raise document.fault((name, "substance"), "a substance of substances.yaml", repr(rows[name].substance))
        found[surface] = MappingProxyType(rows)
    return MappingProxyType(found)


@read_once
def skins(root: Path | None = None) -> Mapping[str, TextureRecipe]:
    """All pictures of objects by id, of every file under registry/skins/.

    Raises:
        RegistryError: a row names an unknown key, kind or substance, or its id is taken.
    """
    substances = _known(root).substances
    taken = {name: rows for rows, names in (recipes() if root is None else recipes(root)).items() for name in names}
    found: dict[str, TextureRecipe] = {}
    for stem in names_in(SKINS, root):
        document = read_table_file(f"{SKINS}/{stem}.yaml", root)
        if not isinstance(document.value, dict):
            raise document.fault((), "a mapping of ids to recipes", type(document.value).__name__)
        for name, stated in document.value.items():
            if name in taken or name in found:
                raise document.fault((name,), "an id that no other picture has", repr(name))
            found[name] = _recipe(document, name, stated, None)
            if found[name].substance not in substances:
                substance = repr(found[name].substance)
                raise document.fault((name, "substance"), "a substance of substances.yaml", substance)
    return MappingProxyType(found)


def _known(root: Path | None) -> registry.Registry:
    """The registry in a folder; that of the package as all others ask for it, so that it is not read a second time."""
    return registry.load() if root is None else registry.load(root)


def _recipe(document: Document, name: str, stated: Any, surface: Surface | None) -> TextureRecipe:
    """A checked row; its params are those of its kind, with everything spelled out."""
    row = dict(stated) if isinstance(stated, dict) else {}
    kind = KINDS.get(str(row.get("kind")))
    if kind is None:
        raise document.fault((name, "kind"), f"one of {', '.join(sorted(KINDS))}", repr(row.get("kind")))
    params = registry.read_record(kind.params, row.pop("params", {}), document, (name, "params"))
    row["params"] = params.to_json()
    return registry.read_record(TextureRecipe, row, document, (name,), id=name, surface=surface)


@read_once
def every_recipe() -> Mapping[str, TextureRecipe]:
    """The recipes of all surfaces and of all objects, by id."""
    return MappingProxyType({n: r for group in (*recipes().values(), skins()) for n, r in group.items()})


def find_recipe(name: str) -> TextureRecipe:
    """The recipe of that id. Raises UnknownId with the nearest names."""
    rows = every_recipe()
    if name not in rows:
        raise UnknownId("texture", name, rows)
    return rows[name]


def origin_of(recipe: TextureRecipe) -> str:
    """Where a recipe comes from: the name of the project, or of this package."""
    if recipe.surface is not None:
        return origin_of_row(f"{FOLDER}/{recipe.surface.value}.yaml", recipe.id)
    tables = (f"{SKINS}/{stem}.yaml" for stem in names_in(SKINS))
    return origin_of_row(next(table for table in tables if recipe.id in read_table_file(table).value), recipe.id)


def picture_px(recipe: TextureRecipe) -> int:
    """Pixels along the longer side of the picture of a recipe."""
    return SKIN_PX if recipe.surface is None else SIZE_PX


def finish_key(recipe: TextureRecipe, size_px: int | None = None) -> str:
    """Key of `finish_of`: the code of the recipe's own kind and of no other, the recipe and its substance."""
    size_px = size_px or picture_px(recipe)
    substance = registry.load().substances[recipe.substance]
    return digest_of("texture", _code_key(recipe.kind), recipe.digest, substance.digest, size_px)


@cache
def _code_key(kind: str) -> str:
    return key_of(*modules_holding(kind_of(kind), kinds.__name__), paint, finish)


def finish_of(recipe: TextureRecipe, cache: Path, size_px: int | None = None) -> Finish:
    """The finish of a recipe, from `<cache>/textures` or painted now. Finishes used longest ago make room for it."""
    size_px = size_px or picture_px(recipe)
    store = Store(cache / FOLDER)
    key = finish_key(recipe, size_px)
    kept = store.get(key)
    if kept is not None:
        return Finish.from_json(kept)
    substance = registry.load().substances[recipe.substance]
    made = finish(recipe.id, recipe.tile_m, make(recipe, size_px), substance)
    if recipe.surface is None:  # it covers a whole thing and does not repeat
        made = made.replace(material=made.material.replace(tile_m=None))
    store.put(key, made.to_json().encode())
    store.trim(int(CACHE_SHARE * max_cache_bytes()))
    return made
