"""Finishes by id: plain ones from the registry, pictured ones from recipes or packs, painted ahead in threads.

What is painted is kept in the cache; the files of a picture of a pack are read in place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from casa_assets import registry
from casa_assets.asset.family import AvailableFinishes
from casa_assets.cache.cache_key import digest_of, key_of, modules_holding
from casa_assets.cache.store import Store
from casa_assets.core.numeric import linear_from_srgb, srgb_from_hex
from casa_assets.core.system import is_worker, max_cache_bytes
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.record import Vec4
from casa_assets.model.registry.document import Document
from casa_assets.model.registry.rows import Finish, Plain, Surface, TextureRecipe
from casa_assets.projects import in_use, project_folder, read_once, using
from casa_assets.registry.families import look_samplers
from casa_assets.registry.plugins import CONTENT, or_of_ignored
from casa_assets.registry.plugins.textures import plugin_kinds, texture_kinds
from casa_assets.registry.read import load_project, names_in, origin_of_row, read_table_file
from casa_assets.textures.canvas import SIZE_PX, Layers, paint
from casa_assets.textures.finish import finish
from casa_assets.textures.pack_entry import Pack
from casa_assets.textures.run import pictures

FOLDER = "textures"  # of the registry, and within a cache
SKINS = "skins"  # of the registry
SKIN_PX = 384  # longer side of the picture of an object
CACHE_SHARE = 0.5  # part of the bound of a cache that finishes may take
# Pictures of a kitchen are painted in threads, while parts of it that need none of them, or have theirs, are built:
# painting is work on large arrays, during which Python lets other threads run, and takes some 100 MB each.
THREADS = 2
# Paints one finish. What it raises is raised where the finish is asked for.
Painting = Callable[[], Finish]
# Gives the paintings that have begun by their keys, once the first of them is missing.
_BEGUN: ContextVar[Callable[[], Mapping[str, Future[Finish]]] | None] = ContextVar("paintings", default=None)


@contextmanager
def painting_ahead(all_missing: Callable[[], Mapping[str, Painting]]) -> Iterator[None]:
    """Context in which the first finish that has to be painted starts the painting of all others in parallel.

    It has no effect in a worker process, because other workers use the other cores. all_missing: returns the finishes
    that will be needed and are not in the cache, by key, first needed first.
    """
    if is_worker():
        yield
        return
    pool, use = ThreadPoolExecutor(THREADS), in_use()

    def paint(each: Painting) -> Finish:
        with using(use):
            return each()

    token = _BEGUN.set(cache(lambda: {key: pool.submit(paint, each) for key, each in all_missing().items()}))
    try:
        yield
    finally:
        _BEGUN.reset(token)
        pool.shutdown(wait=True, cancel_futures=True)


def painted(key: str, painting: Painting) -> Finish:
    """A finish, painted in this thread, or by those that have begun with it."""
    begun = _BEGUN.get()
    future = None if begun is None else begun().get(key)
    return painting() if future is None else future.result()


@read_once
def recipes(root: Path | None = None) -> Mapping[Surface, Mapping[str, TextureRecipe]]:
    """All recipes by surface and id; pictures of the packs of the project in use are among them.

    root: the only folder to read; None: the package's and the project's. Raises RegistryError: a file is missing, or a
    row names an unknown key, kind or substance, or an id occurs twice. OutputError: a pack.json is damaged.
    """
    # Asked for as all others do, so that it is not read a second time.
    substances = (registry.load() if root is None else registry.load(root)).substances
    found: dict[Surface, dict[str, TextureRecipe]] = {}
    taken: dict[str, str] = {}
    for surface in Surface:
        document = read_table_file(f"{FOLDER}/{surface.value}.yaml", root)
        if not isinstance(document.value, dict):
            raise document.fault((), "a mapping of ids to recipes", type(document.value).__name__)
        found[surface] = {}
        for name, stated in document.value.items():
            if name in taken:
                raise document.fault((name,), "an id that no other surface has", f"{name!r}, also in {taken[name]}")
            taken[name] = document.file
            found[surface][name] = _recipe(document, name, stated, surface, substances)
    project = project_folder() if root is None else None
    for folder, pack in pictures.packs_of(project) if project is not None else ():
        for recipe in _pictures(folder, pack, taken):
            assert recipe.surface is not None
            found[recipe.surface][recipe.id] = recipe
    return MappingProxyType({surface: MappingProxyType(rows) for surface, rows in found.items()})


def _pictures(folder: Path, pack: Pack, taken: dict[str, str]) -> Iterator[TextureRecipe]:
    """The pictures of a pack as recipes; their ids are put into `taken`. Raises RegistryError."""
    known, file = registry.load(), str(folder / pictures.PACK)
    for number, picture in enumerate(pack.pictures):
        if picture.id in taken or picture.id in known.materials:
            held = taken.get(picture.id, "materials.yaml")
            expected = "an id that nothing else has; ingest the pack anew under another name (--pack)"
            raise RegistryError(file, 1, f"pictures.{number}.id", expected, f"{picture.id!r}, also in {held}")
        if picture.substance not in known.substances:
            pointer = f"pictures.{number}.substance"
            raise RegistryError(file, 1, pointer, "a substance of substances.yaml", repr(picture.substance))
        taken[picture.id] = file
        yield pictures.recipe_of(folder.name, picture)


@read_once
def skins() -> Mapping[str, TextureRecipe]:
    """All pictures of objects by id, of every file under registry/skins/. Raises RegistryError."""
    substances = registry.load().substances
    taken = {name for names in recipes().values() for name in names}
    found: dict[str, TextureRecipe] = {}
    for stem in names_in(SKINS):
        document = read_table_file(f"{SKINS}/{stem}.yaml")
        if not isinstance(document.value, dict):
            raise document.fault((), "a mapping of ids to recipes", type(document.value).__name__)
        for name, stated in document.value.items():
            if name in taken or name in found:
                raise document.fault((name,), "an id that no other picture has", repr(name))
            found[name] = _recipe(document, name, stated, None, substances)
    return MappingProxyType(found)


def _recipe(
    document: Document, name: str, stated: Any, surface: Surface | None, substances: Mapping[str, Substance]
) -> TextureRecipe:
    """A checked row; its params are those of its kind, with everything spelled out."""
    row = dict(stated) if isinstance(stated, dict) else {}
    known = texture_kinds()
    kind = known.get(str(row.get("kind")))
    if kind is None:
        expected = f"one of {', '.join(sorted(known))}{or_of_ignored()}"
        raise document.fault((name, "kind"), expected, repr(row.get("kind")))
    params = registry.read_record(kind.params, row.pop("params", {}), document, (name, "params"))
    row["params"] = params.to_json()
    recipe = registry.read_record(TextureRecipe, row, document, (name,), id=name, surface=surface)
    if recipe.substance not in substances:
        raise document.fault((name, "substance"), "a substance of substances.yaml", repr(recipe.substance))
    return recipe


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
    """Where a recipe comes from: the name of the project, with that of the pack of a picture, or of this package."""
    if pack := pictures.pack_of(recipe):
        loaded = load_project()
        assert loaded is not None
        return f"{loaded[0].name}/{pack}"
    if recipe.surface is not None:
        return origin_of_row(f"{FOLDER}/{recipe.surface.value}.yaml", recipe.id)
    tables = (f"{SKINS}/{stem}.yaml" for stem in names_in(SKINS))
    return origin_of_row(next(table for table in tables if recipe.id in read_table_file(table).value), recipe.id)


def picture_px(recipe: TextureRecipe) -> int:
    """Pixels along the longer side of the picture of a recipe."""
    return SKIN_PX if recipe.surface is None else SIZE_PX


def layers_of(recipe: TextureRecipe, size_px: int) -> Layers:
    """Return the painted layers of a recipe, or the picture of a pack, at most `size_px` pixels on the longer side."""
    if recipe.kind == pictures.KIND:
        return pictures.layers_of_picture(recipe, size_px)
    return paint(texture_kinds()[recipe.kind], recipe, size_px)


def finish_key(recipe: TextureRecipe, size_px: int | None = None) -> str:
    """Key of `finish_of`: the code of the recipe's own kind and of no other, the recipe and its substance.

    Raises OutputError: a file of a picture is missing, or is not the one that was written.
    """
    size_px = size_px or picture_px(recipe)
    substance = registry.load().substances[recipe.substance]
    if recipe.kind == pictures.KIND:
        pictures.check_files(recipe)
    return digest_of("texture", _code_key(recipe.kind), recipe.digest, substance.digest, size_px)


@read_once
def _code_key(kind: str) -> str:
    if kind == pictures.KIND:
        return key_of(pictures.finish_of_picture)
    if kind in plugin_kinds():
        return digest_of("plug-in", plugin_kinds()[kind][0].digest, key_of(paint, finish))
    return key_of(*modules_holding(texture_kinds()[kind], CONTENT), paint, finish)


def finish_of(recipe: TextureRecipe, cache: Path, size_px: int | None = None) -> Finish:
    """The finish of a recipe, from `<cache>/textures` or painted now. Finishes used longest ago make room for it.

    Pictures of packs are read from their files. Raises OutputError: one is missing, or is not the one that was written.
    """
    size_px = size_px or picture_px(recipe)
    substance = registry.load().substances[recipe.substance]
    if recipe.kind == pictures.KIND:
        if size_px < SIZE_PX:
            return pictures.resized_finish(recipe, substance, size_px)
        return pictures.finish_of_picture(recipe, substance)
    store = Store(cache / FOLDER, is_optional=True)
    key = finish_key(recipe, size_px)
    kept = store.get(key)
    if kept is not None:
        return Finish.from_json(kept)
    return painted(key, partial(_paint_and_keep, recipe, size_px, store, key))


def missing_paintings(names: Iterable[str], cache: Path) -> dict[str, Painting]:
    """What `finish_of` has to paint of the finishes of some ids, by key; not what a plug-in paints."""
    store, found, pictured = Store(cache / FOLDER, is_optional=True), dict[str, Painting](), every_recipe()
    for name in names:
        recipe = pictured.get(name)
        if recipe is None or recipe.kind == pictures.KIND or recipe.kind in plugin_kinds():
            continue
        size_px, key = picture_px(recipe), finish_key(recipe)
        if store.get(key) is None:
            found[key] = partial(_paint_and_keep, recipe, size_px, store, key)
    return found


def _paint_and_keep(recipe: TextureRecipe, size_px: int, store: Store, key: str) -> Finish:
    made = finish(recipe.id, recipe.tile_m, layers_of(recipe, size_px), registry.load().substances[recipe.substance])
    if recipe.surface is None:  # it covers a whole thing and does not repeat
        made = made.replace(material=made.material.replace(tile_m=None))
    store.put(key, made.to_json().encode())
    store.trim(int(CACHE_SHARE * max_cache_bytes()))
    return made


def available_finishes() -> AvailableFinishes:
    """Ids of everything that a draw may choose."""
    data = registry.load()
    surfaces: Mapping[Surface, tuple[str, ...]] = {s: tuple(sorted(rows)) for s, rows in recipes().items()}
    return AvailableFinishes(surfaces, tuple(sorted(data.materials)), look_samplers())


@read_once
def plain() -> Mapping[str, Finish]:
    """Every plain finish of the registry."""
    data = registry.load()
    return {name: plain_finish(row, data) for name, row in data.materials.items()}


def plain_finish(row: Plain, data: registry.Registry) -> Finish:
    """A row of registry/materials.yaml as a finish."""
    material = Material(
        id=row.id,
        base_color=linear(row.color, row.opacity),
        metallic=row.metallic,
        roughness=row.roughness,
        glow=row.glow,
        substance=row.substance,
    )
    return Finish(id=row.id, material=material, substance=data.substances[row.substance])


def linear(color: str, opacity: float = 1.0) -> Vec4:
    """`#rrggbb` in sRGB as linear RGBA."""
    r, g, b = (round(linear_from_srgb(v), 6) for v in srgb_from_hex(color))
    return (r, g, b, opacity)


@read_once
def plain_key() -> str:
    """Digest of every plain finish."""
    return digest_of([(name, finish.digest) for name, finish in sorted(plain().items())])


def finishes_key(names: Iterable[str]) -> str:
    """Key of `finishes`: plain ones by value, pictures by what paints them. Raises UnknownId: it is neither."""
    pictured = sorted(name for name in names if name not in plain())
    return digest_of(plain_key(), [(name, finish_key(find_recipe(name))) for name in pictured])


def finishes(names: Iterable[str], cache: Path) -> dict[str, Finish]:
    """All plain finishes, and those named that have pictures. Raises UnknownId: neither a plain finish nor a recipe."""
    by_id = dict(plain())
    pictured = every_recipe()
    for name in names:
        if name in by_id:
            continue
        if name not in pictured:
            raise UnknownId("finish", name, [*by_id, *pictured])
        by_id[name] = finish_of(pictured[name], cache)
    return by_id
