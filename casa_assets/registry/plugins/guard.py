"""Report errors in the code of a plug-in as errors of that plug-in."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from casa_assets.errors import CasaError, PluginFailure
from casa_assets.registry.plugins.load import LoadedPlugin

P = ParamSpec("P")
R = TypeVar("R")


def guarded(one: LoadedPlugin, what: str, function: Callable[P, R]) -> Callable[P, R]:
    """The same function, but with its errors raised as PluginFailure; CasaError and MemoryError pass unchanged."""

    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except (CasaError, MemoryError):
            raise
        except Exception as error:
            message = f"{what}: {type(error).__name__}: {error}"
            raise PluginFailure(one.plugin.name, message, traceback.format_exc()) from error

    return call
