"""The record that describes a plug-in, and the protocols that its parts have to implement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

# Only for types: what imports this module has not to load all that plug-ins can add to, and is not made from it.
if TYPE_CHECKING:
    from casa_assets.asset.assemble import Family
    from casa_assets.checks.check import Check
    from casa_assets.model.asset.asset import Asset
    from casa_assets.textures.canvas import TextureKind

__all__ = ["Exporter", "Plugin", "Source"]


@runtime_checkable
class Source(Protocol):
    """Brings meshes for `ingest`, by an address `<scheme>:<rest>` in place of a path.

    Attributes:
        scheme: begins the addresses, such as `depot`; letters and digits, and none that stores have, such as `s3`.
    """

    scheme: str

    def fetch(self, address: str, folder: Path) -> None:
        """Write meshes into an empty folder, with a manifest.jsonl for what is known of them.

        Args:
            address: as the user wrote it, with its scheme.
        """


@runtime_checkable
class Exporter(Protocol):
    """Writes assets in its own format, for `casa-assets export plugin NAME`.

    Attributes:
        name: as the command takes it. about: what is written, one sentence.
    """

    name: str
    about: str

    def write(self, asset: Asset) -> Mapping[str, bytes]:
        """The files of an asset by their paths below its folder, such as `model.json`; the same each time."""


@dataclass(frozen=True)
class Plugin:
    """Code that adds to casa-assets, under a name and with a version that certificates state.

    A module in `plugins/` of a project, or one that an entry point of the group `casa_assets.plugins` names, has it as
    `PLUGIN`. Names must be new: nothing of the package or of another plug-in is replaced.

    Attributes:
        name, version: such as `tea_things`, `1.2`.
        families: for `families build`, plans and styles; their category is a row of fixtures.yaml.
        forms: of objects; rows of `objects/` in a project name them.
        checks: run in addition to those of the package, each on subjects of its type. Codes of capital letters and
            three digits, such as `TEA001`.
        limits: numbers that the checks compare with, by key; a row of limits.yaml in a project changes one.
        texture_kinds: rows of `textures/` in a project name them.
        sources, exporters: see there.
    """

    name: str
    version: str
    families: tuple[Family[Any], ...] = ()
    forms: tuple[Family[Any], ...] = ()
    checks: tuple[Check, ...] = ()
    limits: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    texture_kinds: tuple[TextureKind, ...] = ()
    sources: tuple[Source, ...] = ()
    exporters: tuple[Exporter, ...] = ()
