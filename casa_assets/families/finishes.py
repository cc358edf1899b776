"""Finishes by id: plain ones out of the registry, pictured ones out of their recipes, kept in the store."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from casa_assets import registry
from casa_assets.asset.family import AvailableFinishes
from casa_assets.cache.cache_key import digest_of
from casa_assets.core.numeric import linear_from_srgb, srgb_from_hex
from casa_assets.errors import UnknownId
from casa_assets.model.asset.material import Material
from casa_assets.model.record import Vec4
from casa_assets.model.registry.rows import Finish, Plain, Surface
from casa_assets.projects import read_once
from casa_assets.registry.families import look_samplers
from casa_assets.textures.run.recipes import every_recipe, find_recipe, finish_key, finish_of, recipes


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
    """Key of `finishes`: all plain ones by value, of those with pictures what they are painted from and by.

    Raises:
        UnknownId: neither a plain finish nor a recipe.
    """
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
