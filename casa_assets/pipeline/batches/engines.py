"""The engines that step a batch, by name; each is imported when it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from casa_assets.errors import CasaError, UnknownId
from casa_assets.pipeline.batches.engine import Engine, Parts

# Name -> module beside this one, its class, and what to install for it.
ENGINES = {
    "mujoco": ("mujoco_engine", "MujocoEngine", "mujoco"),
    "mujoco_warp": ("mujoco_warp_engine", "MujocoWarpEngine", "mujoco-warp"),
    "mjx": ("mjx_engine", "MjxEngine", "mujoco-mjx"),
    "newton": ("newton_engine", "NewtonEngine", "newton mujoco-warp"),
}


def engine_named(name: str) -> Callable[[Parts], Engine]:
    """What makes an engine. Raises UnknownId for another name, CasaError where it is not installed."""
    if name not in ENGINES:
        raise UnknownId("engine", name, ENGINES)
    module, kind, packages = ENGINES[name]
    try:
        found: Callable[[Parts], Engine] = getattr(import_module(f"casa_assets.pipeline.batches.{module}"), kind)
    except ImportError as error:
        raise CasaError(f"the engine {name} is not installed ({error}): pip install {packages}") from error
    return found
