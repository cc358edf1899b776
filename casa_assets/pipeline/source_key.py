"""A digest of all that decides what a scene is, so that an unchanged one is not made again."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

from casa_assets.pipeline.kitchens import Recipe
from casa_assets.registry import data_root

# What a scene is made by, and packages whose versions may change it.
PARTS = ("families", "textures", "layouts", "geometry", "model", "export", "pipeline", "checks/design")
TOOLS = ("numpy", "scipy", "manifold3d", "pillow", "usd-core")
# What besides decides the verdict on it.
JUDGES = ("checks", "preview")
JUDGING_TOOLS = ("mujoco", "simready-foundation-tier-core")


@lru_cache(maxsize=2)
def source_digest(parts: tuple[str, ...] = PARTS, tools: tuple[str, ...] = TOOLS) -> str:
    """sha256 over the package's own sources and registry/, file by file in order, and the versions of tools."""
    package = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for part in parts:
        for path in sorted((package / part).rglob("*.py")):
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes())
    root = data_root()
    for path in sorted(root.rglob("*.yaml")):
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
