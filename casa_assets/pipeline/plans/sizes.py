"""Sizes of the presets that a style names, read without the code that builds them, which takes seconds to load."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from casa_assets.model.kitchen.style import LIBRARY
from casa_assets.projects import read_once
from casa_assets.registry.layered import read_table_file, read_topmost

Presets = Mapping[str, Mapping[str, Any]]


@read_once
def family_sizes() -> Mapping[str, Mapping[str, Any]]:
    """Rows of registry/family_sizes.yaml. Raises RegistryError."""
    rows: Mapping[str, Mapping[str, Any]] = read_topmost("family_sizes.yaml").value
    return rows


def width_bounds(family: str) -> tuple[float, float] | None:
    """Least and greatest width that a family can be built in, metres; None where it has no width, or is not known."""
    return _bounds(family, "width")


def height_bounds(family: str) -> tuple[float, float] | None:
    """The same of its height."""
    return _bounds(family, "height")


def _bounds(family: str, side: str) -> tuple[float, float] | None:
    found = family_sizes().get(family, {}).get(side)
    return (float(found[0]), float(found[1])) if found else None


class PresetSizes(Mapping[str, Presets]):
    """What layouts ask of presets, by family; a family is read when it is asked for."""

    def __init__(self) -> None:
        self._read: dict[str, Presets] = {}

    def __getitem__(self, name: str) -> Presets:
        if name not in self._read:
            self._read[name] = _presets_of(name)
        return self._read[name]

    def __contains__(self, name: object) -> bool:
        return name in family_sizes() or name in _all_families() or name == LIBRARY

    def __iter__(self) -> Iterator[str]:
        return iter(_all_families())

    def __len__(self) -> int:
        return len(_all_families())


def _presets_of(name: str) -> Presets:
    if name == LIBRARY:
        from casa_assets.pipeline.kitchens.library_assets import LibraryPresets  # loads what reads meshes

        return LibraryPresets()
    if name not in family_sizes():
        from casa_assets.registry.families import family  # loads the code of all families

        return {k: p.model_dump(mode="json") for k, p in family(name).presets.items()}
    defaults = family_sizes()[name]["defaults"]
    rows = read_table_file(f"families/{name}.yaml").value["presets"]
    return {preset: {**defaults, **(row or {})} for preset, row in rows.items()}


def _all_families() -> tuple[str, ...]:
    from casa_assets.registry.layered import names_in

    return tuple(sorted({*family_sizes(), *names_in("families")}))
