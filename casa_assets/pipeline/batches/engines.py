"""The engines that step a batch, by name; each is imported when it is asked for."""

from __future__ import annotations

from collections.abc import Callable

from casa_assets.errors import CasaError, UnknownId
from casa_assets.pipeline.batches.engine import Engine, Parts

EngineMaker = Callable[[Parts], Engine]


def _mujoco() -> EngineMaker:
    from casa_assets.pipeline.batches.mujoco_engine import MujocoEngine

    return MujocoEngine


def _mujoco_warp() -> EngineMaker:
    from casa_assets.pipeline.batches.mujoco_warp_engine import MujocoWarpEngine

    return MujocoWarpEngine


def _mjx() -> EngineMaker:
    from casa_assets.pipeline.batches.mjx_engine import MjxEngine

    return MjxEngine


def _newton() -> EngineMaker:
    from casa_assets.pipeline.batches.newton_engine import NewtonEngine

    return NewtonEngine


# Name -> what imports it, and what to install for it.
ENGINES: dict[str, tuple[Callable[[], EngineMaker], str]] = {
    "mujoco": (_mujoco, "mujoco"),
    "mujoco_warp": (_mujoco_warp, "mujoco-warp"),
    "mjx": (_mjx, "mujoco-mjx"),
    "newton": (_newton, "newton mujoco-warp"),
}


def engine_named(name: str) -> EngineMaker:
    """What makes an engine. Raises UnknownId for another name, CasaError where it is not installed."""
    if name not in ENGINES:
        raise UnknownId("engine", name, ENGINES)
    load, packages = ENGINES[name]
    try:
        return load()
    except ImportError as error:
        raise CasaError(f"the engine {name} is not installed ({error}): pip install {packages}") from error
