"""Decide whether an articulated mesh meets the RoboCasa contract of its category.

An asset names a contract only where every check of it passes: names and paths, poses and states as MuJoCo operates
them, and what a hand has to be able to move. Otherwise the failed checks are reported.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from casa_assets.checks.check import Check
from casa_assets.checks.package.package import Package
from casa_assets.checks.run import run
from casa_assets.checks.table.table import TABLE
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.issue import Severity
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.contract import Contract

# What is there and how it is called; looked at first, for it costs nothing.
NAME_CODES = ("CON", "BEH001", "BEH002")
# How it moves and what it holds: rows that look at nothing but what a runtime operates.
MOTION_CODES = ("BEH003", "KIN", "HOL", "AST017")
# Of the faults that are kept with the asset.
MAX_LISTED_FAULTS = 6


def unmet_checks(
    asset: Asset, category: Category, root: Path, contract: Contract | None, limits: Mapping[str, float]
) -> tuple[str, ...]:
    """Return the failed checks of the contract that an asset names; empty where it meets it.

    Args:
        root: where its MJCF is written.
    """
    for codes in (NAME_CODES, MOTION_CODES):
        rows = [check for check in TABLE if check.code.startswith(codes) and check.severity is Severity.ERROR]
        faults = _faults(asset, Package(asset, category, root, contract), limits, rows)
        if faults:
            return faults
    return ()


def explanation(contract: str, known: Contract | None) -> str:
    """Return the sentence that says what an asset cannot be used for that does not meet a contract.

    Args:
        contract: id. known: its record, which names the fixture classes of RoboCasa that read it.
    """
    classes = sorted({name for names in (known.read_by.values() if known is not None else ()) for name in names})
    reader = f"RoboCasa's fixture class {' or '.join(classes)}" if classes else "RoboCasa"
    return f"contract {contract} not met: {reader} cannot use it; kitchens, MuJoCo and Isaac Sim can"


def without_contract(asset: Asset, faults: tuple[str, ...]) -> Asset:
    """Return the asset without a contract, with the reason in its provenance."""
    first = "; ".join(faults[:MAX_LISTED_FAULTS]) + (
        f"; and {len(faults) - MAX_LISTED_FAULTS} more" if len(faults) > MAX_LISTED_FAULTS else ""
    )
    guess = Guess(subject="contract", value=f"not {asset.contract}", confidence=1.0, reason=first)
    provenance = asset.provenance.replace(guesses=(*asset.provenance.guesses, guess))
    return asset.replace(contract=None, provenance=provenance)


def _faults(asset: Asset, package: Package, limits: Mapping[str, float], rows: list[Check]) -> tuple[str, ...]:
    """Run some checks on the asset and its package; return their errors as lines."""
    issues = [i for subject in (asset, package) for i in run(subject, asset.id, limits, table=rows).errors]
    return tuple(f"{i.code} {i.pointer}: {i.message}" if i.pointer else f"{i.code} {i.message}" for i in issues)
