"""Kitchens and kitchen assets for simulation, as MJCF and USD: generated from parameters, or made from meshes.

import casa_assets as casa
model = casa.kitchen("l_small", "coastal", seed=7).to_mjmodel()
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from casa_assets.api.assets import StablePose, build, load, stable_poses
    from casa_assets.api.batch import Batch, BatchKitchen, batch
    from casa_assets.api.behaviors import Behaviors, FixtureStates, StartStates
    from casa_assets.api.catalogue import (
        Bounds,
        FamilyInfo,
        PlanInfo,
        StyleInfo,
        families,
        plans,
        plugins,
        styles,
        surfaces,
    )
    from casa_assets.api.kitchen import Detail, Kitchen, kitchen
    from casa_assets.api.library import Articulated, Ingested, IngestResult, Library, Rejection, articulate, ingest
    from casa_assets.api.projects import MadeRun, Project, ingest_textures
    from casa_assets.core.system import cache_dir
    from casa_assets.errors import CasaError, OutputError, RegistryError, Rejected, UnknownId
    from casa_assets.ingest.run.inputs import MeshInput
    from casa_assets.layouts.run.load_scene import SurfaceTextures
    from casa_assets.library.entry import Entry
    from casa_assets.library.search import SearchHit
    from casa_assets.model.asset.asset import Asset
    from casa_assets.model.issue import Issue, Report
    from casa_assets.textures.run.packs import PackReport

__version__ = "0.2.0"
__all__ = ["__version__"]
# Lists of plans, styles and so on.
__all__ += ["plans", "styles", "families", "surfaces", "plugins", "PlanInfo", "StyleInfo", "FamilyInfo", "Bounds"]
# Kitchens.
__all__ += ["kitchen", "Kitchen", "Detail", "Behaviors", "FixtureStates", "StartStates", "SurfaceTextures"]
__all__ += ["batch", "Batch", "BatchKitchen"]
# Assets, meshes and libraries.
__all__ += ["build", "load", "Asset", "Report", "Issue", "stable_poses", "StablePose"]
__all__ += ["ingest", "Ingested", "articulate", "Articulated", "Rejection"]
__all__ += ["Library", "MeshInput", "IngestResult", "Entry", "SearchHit"]
# Projects, textures and errors.
__all__ += ["Project", "MadeRun", "ingest_textures", "PackReport", "cache_dir"]
__all__ += ["CasaError", "UnknownId", "RegistryError", "OutputError", "Rejected"]
# Module -> names that are imported from it when they are first used, so that the command line starts without numpy.
_NAMES = {
    "api.assets": ("build", "load", "stable_poses", "StablePose"),
    "api.batch": ("batch", "Batch", "BatchKitchen"),
    "api.behaviors": ("Behaviors", "FixtureStates", "StartStates"),
    "api.catalogue": (
        *("plans", "styles", "families", "surfaces", "plugins"),
        *("PlanInfo", "StyleInfo", "FamilyInfo", "Bounds"),
    ),
    "api.kitchen": ("kitchen", "Kitchen", "Detail"),
    "api.library": ("Library", "ingest", "articulate", "Ingested", "IngestResult", "Articulated", "Rejection"),
    "api.projects": ("Project", "MadeRun", "ingest_textures"),
    "core.system": ("cache_dir",),
    "errors": ("CasaError", "UnknownId", "RegistryError", "OutputError", "Rejected"),
    "model.asset.asset": ("Asset",),
    "model.issue": ("Issue", "Report"),
    "library.search": ("SearchHit",),
    "ingest.run.inputs": ("MeshInput",),
    "layouts.run.load_scene": ("SurfaceTextures",),
    "library.entry": ("Entry",),
    "textures.run.packs": ("PackReport",),
}
SOURCES = {name: f"casa_assets.{module}" for module, names in _NAMES.items() for name in names}


class _Package(ModuleType):
    """The type of this package: `casa_assets.ingest` is the function, though there is a folder of that name too.

    Importing `casa_assets.formats.read` makes Python set the subpackage as an attribute of the package. This is ignored
    if the package offers a function of the same name. `import casa_assets.formats.read` and `from casa_assets.ingest
    import load` find subpackages in sys.modules and work as usual.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in SOURCES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


if not TYPE_CHECKING:  # else type checkers would take every misspelt name for one that is there

    def __getattr__(name: str) -> Any:
        """Import a name that the package offers when it is first used."""
        if name not in SOURCES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(SOURCES[name]), name)
        setattr(sys.modules[__name__], name, value)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
