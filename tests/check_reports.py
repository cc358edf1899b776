"""What the table of checks says of an asset and of its MJCF package."""

from __future__ import annotations

from pathlib import Path

from casa_assets import registry
from casa_assets.checks.package.package import Package
from casa_assets.checks.run import run
from casa_assets.checks.table.table import TABLE
from casa_assets.export.mjcf import write
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from tests.assets import category, write_to

LIMITS = registry.load().limits


def packed(asset: Asset, folder: Path) -> Package:
    return Package(asset, category(asset), write_to(write(asset), folder / asset.digest[:12]))


def judged(asset: Asset, folder: Path) -> Report:
    """By every row of the asset and of its MJCF package; those of USD have nothing to say of what is changed here."""
    rows = [check for check in TABLE if not check.code.startswith(("USD", "PAR"))]
    whole = run(asset, asset.id, LIMITS, table=rows)
    return whole + run(packed(asset, folder), asset.id, LIMITS, table=rows)


def codes(asset: Asset, folder: Path) -> set[str]:
    return {issue.code for issue in judged(asset, folder).issues}


def number(code: str, asset: Asset, folder: Path) -> float:
    found = {r.code: r.number for r in judged(asset, folder).results}[code]
    assert found is not None
    return found
