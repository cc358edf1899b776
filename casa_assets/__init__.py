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
    from casa_assets.api.assets import (
        StablePose,
        build,
        build_object,
        check,
        ingest_textures,
        read_asset,
        sample,
        stable_poses,
        write,
    )
    from casa_assets.api.batch import Batch, BatchKitchen, batch
    from casa_assets.api.behaviors import Behaviors, FixtureStates, StartStates
    from casa_assets.api.catalogue import (
        Bounds,
        FamilyInfo,
        MadeRun,
        PlanInfo,
        StyleInfo,
        families,
        make,
        plans,
        plugins,
        styles,
        surfaces,
    )
    from casa_assets.api.kitchen import Kitchen, Weight, kitchen, load_scene, start_states
    from casa_assets.api.library import Articulated, Ingested, IngestResult, Library, Rejection, articulate, ingest
    from casa_assets.core.system import cache_dir
    from casa_assets.errors import CasaError, OutputError, RegistryError, Rejected, UnknownId
    from casa_assets.geometry.mesh.trimesh_exchange import to_trimesh
    from casa_assets.model.asset.asset import Asset
    from casa_assets.model.issue import Issue, Report
    from casa_assets.pipeline.dedup.search import SearchHit
    from casa_assets.pipeline.ingest.in_memory import MeshInput
    from casa_assets.pipeline.kitchens.load_scene import SurfaceTextures
    from casa_assets.pipeline.reports.entry import Entry
    from casa_assets.pipeline.textures.packs.ingest import PackReport
    from casa_assets.projects import use_project

__version__ = "0.1.0"
__all__ = [
    "__version__",
    "plans",
    "styles",
    "families",
    "surfaces",
    "kitchen",
    "load_scene",
    "start_states",
    "batch",
    "Behaviors",
    "ingest",
    "articulate",
    "ingest_textures",
    "build",
    "build_object",
    "sample",
    "check",
    "write",
    "read_asset",
    "to_trimesh",
    "stable_poses",
    "Library",
    "cache_dir",
    "use_project",
    "make",
    "plugins",
    "Kitchen",
    "Weight",
    "FixtureStates",
    "StartStates",
    "Batch",
    "BatchKitchen",
    "StablePose",
    "SurfaceTextures",
    "Asset",
    "Report",
    "Issue",
    "Ingested",
    "IngestResult",
    "MeshInput",
    "Entry",
    "SearchHit",
    "Articulated",
    "PackReport",
    "MadeRun",
    "Rejection",
    "PlanInfo",
    "StyleInfo",
    "FamilyInfo",
    "Bounds",
    "CasaError",
    "UnknownId",
    "RegistryError",
    "OutputError",
    "Rejected",
]
# Name -> module that it is imported from when it is first asked for, so that the command line starts without numpy.
_SOURCES = {
    **dict.fromkeys(("build", "build_object", "check", "read_asset", "sample", "write"), "casa_assets.api.assets"),
    **dict.fromkeys(("plans", "styles", "families", "surfaces", "plugins"), "casa_assets.api.catalogue"),
    **dict.fromkeys(("PlanInfo", "StyleInfo", "FamilyInfo", "Bounds"), "casa_assets.api.catalogue"),
    **dict.fromkeys(("Behaviors", "FixtureStates"), "casa_assets.api.behaviors"),
    **dict.fromkeys(("Kitchen", "Weight", "kitchen", "load_scene", "start_states"), "casa_assets.api.kitchen"),
    "StartStates": "casa_assets.api.behaviors",
    **dict.fromkeys(("Batch", "BatchKitchen", "batch"), "casa_assets.api.batch"),
    "ingest_textures": "casa_assets.api.assets",
    **dict.fromkeys(("MadeRun", "make"), "casa_assets.api.catalogue"),
    "PackReport": "casa_assets.pipeline.textures.packs.ingest",
    **dict.fromkeys(("StablePose", "stable_poses"), "casa_assets.api.assets"),
    **dict.fromkeys(("Library", "ingest", "articulate"), "casa_assets.api.library"),
    **dict.fromkeys(("Ingested", "IngestResult", "Articulated", "Rejection"), "casa_assets.api.library"),
    **dict.fromkeys(("CasaError", "UnknownId", "RegistryError", "OutputError", "Rejected"), "casa_assets.errors"),
    "SurfaceTextures": "casa_assets.pipeline.kitchens.load_scene",
    "Asset": "casa_assets.model.asset.asset",
    **dict.fromkeys(("Issue", "Report"), "casa_assets.model.issue"),
    "Entry": "casa_assets.pipeline.reports.entry",
    "SearchHit": "casa_assets.pipeline.dedup.search",
    "MeshInput": "casa_assets.pipeline.ingest.in_memory",
    "cache_dir": "casa_assets.core.system",
    "use_project": "casa_assets.projects",
    "to_trimesh": "casa_assets.geometry.mesh.trimesh_exchange",
}


class _Package(ModuleType):
    """The type of this package: `casa_assets.ingest` is the function, though there is a folder of that name too.

    Importing `casa_assets.ingest.load` makes Python set the subpackage as an attribute of the package. This is ignored
    if the package offers a function of the same name. `import casa_assets.ingest.load` and `from casa_assets.ingest
    import load` find subpackages in sys.modules and work as usual.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _SOURCES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


if not TYPE_CHECKING:  # else type checkers would take every misspelt name for one that is there

    def __getattr__(name: str) -> Any:
        """Import a name that the package offers when it is first used."""
        if name not in _SOURCES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(_SOURCES[name]), name)
        setattr(sys.modules[__name__], name, value)
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
