"""Checks that plug-ins add; they run with those of the package, on whatever their subject is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from casa_assets.checks.check import Check
from casa_assets.checks.table import TABLE
from casa_assets.projects import read_once
from casa_assets.registry.plugins.load import added, guarded, load_plugins


@read_once
def check_table() -> tuple[Check, ...]:
    """Every row of the table of checks, those of the package first. Raises CasaError where a code is taken."""
    codes = {row.code for row in TABLE}
    found = list(TABLE)
    for one, row in added("check", lambda plugin: plugin.checks, lambda thing: thing.code, codes):
        found.append(replace(row, function=guarded(one, f"check {row.code}", row.function)))
    return tuple(found)


def with_plugin_limits(limits: Mapping[str, float]) -> Mapping[str, float]:
    """Limits of the registry, and those of the checks of plug-ins that it does not state."""
    return {key: value for one in load_plugins() for key, value in one.plugin.limits.items()} | dict(limits)


def checks_versions() -> dict[str, str]:
    """`plugin:<name>` -> version of the plug-ins whose checks are run, for certificates."""
    return {f"plugin:{one.plugin.name}": one.version for one in load_plugins() if one.plugin.checks}
