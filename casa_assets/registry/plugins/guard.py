"""Have errors in the code of a plug-in told as its own."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from casa_assets.errors import CasaError, PluginFailure
from casa_assets.registry.plugins.load import LoadedPlugin

P = ParamSpec("P")
R = TypeVar("R")


def guarded(one: LoadedPlugin, what: str, function: Callable[P, R]) -> Callable[P, R]:
    """The same function, whose errors are told as those of its plug-in. What it raises on purpose stays as it is."""

    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except (CasaError, MemoryError):
            raise
        except Exception as error:
            message = f"{what}: {type(error).__name__}: {error}"
            raise PluginFailure(one.plugin.name, message, traceback.format_exc()) from error

    return call
