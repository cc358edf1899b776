"""A digest of all that decides what a scene is, so that an unchanged one is not made again."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from casa_assets.registry import data_root

if TYPE_CHECKING:
    from casa_assets.pipeline.kitchens import Recipe

# What a scene is made by, and packages whose versions may change it.
PARTS = ("families", "textures", "layouts", "geometry", "model", "export", "pipeline", "checks/design")
TOOLS = ("numpy", "scipy", "manifold3d", "pillow", "usd-core")
# What besides decides the verdict on it.
JUDGES = ("checks", "preview")
JUDGING_TOOLS = ("mujoco", "simready-foundation-tier-core")
# What one asset of a family is made by, and what of the registry reaches it: less than all that a scene is made by, so
# that work on checks, layouts and writers does not throw built assets away.
BUILDERS = (
    "families",
    "textures",
    "geometry",
    "model",
    "pipeline/families.py",
    "pipeline/palette.py",
    "pipeline/textures.py",
    "pipeline/asset_bytes.py",
    "pipeline/asset_store.py",
)
BUILDING_TOOLS = ("numpy", "scipy", "manifold3d", "pillow")
MATTER = (
    "categories.yaml",
    "classes.yaml",
    "densities.yaml",
    "fixtures.yaml",
    "materials.yaml",
    "substances.yaml",
    "textures/*.yaml",
)


@lru_cache(maxsize=2)
def source_digest(parts: tuple[str, ...] = PARTS, tools: tuple[str, ...] = TOOLS) -> str:
    """sha256 over the package's own sources and registry/, file by file in order, and the versions of tools."""
    return _digest(parts, ("**/*.yaml",), tools)


@lru_cache(maxsize=1)
def builders_digest() -> str:
    """The same over what decides what an asset of a family is, besides its numbers."""
    return _digest(BUILDERS, MATTER, BUILDING_TOOLS)


def _digest(parts: tuple[str, ...], rows: tuple[str, ...], tools: tuple[str, ...]) -> str:
    """sha256 over folders and files of the package, files of registry/ by glob, and the versions of tools."""
    package, root = Path(__file__).parent.parent, data_root()
    digest = hashlib.sha256()
    for part in parts:
        at = package / part
        for path in sorted(at.rglob("*.py")) if at.is_dir() else [at]:
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes())
    for pattern in rows:
        for path in sorted(root.glob(pattern)):
            digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    for tool in tools:
        digest.update(f"{tool} {version(tool)}\0".encode())
    return digest.hexdigest()


def key_of(recipe: Recipe) -> str:
    """sha256 of a recipe and of everything that turns it into a scene."""
    return hashlib.sha256(f"{recipe!r}\0{source_digest()}".encode()).hexdigest()


def key_of_verdict(recipe: Recipe) -> str:
    """The same of everything that decides what the checks say of the scene."""
    judges = source_digest(JUDGES, JUDGING_TOOLS)
    return hashlib.sha256(f"{key_of(recipe)}\0{judges}".encode()).hexdigest()
