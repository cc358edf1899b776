"""Assets of libraries that a plan or a style names in place of a family's member: `library:<id>`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from casa_assets.errors import UnknownId
from casa_assets.layouts.compose.compose import box_of
from casa_assets.model.asset.asset import Asset
from casa_assets.pipeline.library.library import Library, read_asset
from casa_assets.projects import SETTINGS, project_folder, read_once
from casa_assets.registry.project import load_project


class LibraryPresets(Mapping[str, Mapping[str, Any]]):
    """Sizes of the assets in the libraries of the project in use, by id; an asset is read when it is asked for."""

    def __getitem__(self, name: str) -> Mapping[str, Any]:
        """Width, depth and height of what an asset takes up without its handles, metres. Raises KeyError."""
        if name not in _folders():
            raise KeyError(name)
        size = box_of(library_asset(name))[1]
        return {key: round(float(value), 4) for key, value in zip(("width", "depth", "height"), size, strict=True)}

    def __iter__(self) -> Iterator[str]:
        """Ids, sorted."""
        return iter(_folders())

    def __len__(self) -> int:
        """How many there are."""
        return len(_folders())


@read_once
def library_asset(name: str) -> Asset:
    """The asset of that id. Raises UnknownId, with the nearest names; OutputError where it cannot be read."""
    folders = _folders()
    if name not in folders:
        raise UnknownId("asset of the libraries of the project", name, folders)
    return read_asset(folders[name])


@read_once
def _folders() -> Mapping[str, Path]:
    """Folder of each accepted asset, by id, sorted; of two libraries with one id the first counts.

    Raises:
        RegistryError: a library that casa.yaml names is not there.
    """
    loaded, place = load_project(), project_folder()
    if loaded is None or place is None:
        return {}
    project, document = loaded
    found: dict[str, Path] = {}
    for number, stated in enumerate(project.libraries):
        folder = place / stated
        if not folder.is_dir():
            raise document.fault(("libraries", number), f"a folder beside {SETTINGS}", repr(stated))
        for one in Library(folder).accepted():
            found.setdefault(one.name, one)
    return dict(sorted(found.items()))
