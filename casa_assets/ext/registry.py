"""The registry, with what a project lays over it."""

from __future__ import annotations

from casa_assets.registry import load as load_registry
from casa_assets.registry.families import object_names
from casa_assets.registry.tables import load_robot

__all__ = [
    "load_registry",
    "load_robot",
    "object_names",
]
