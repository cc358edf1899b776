"""Small assets written to disk, what the table of checks says of them, and packages that were tampered with."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from PIL import Image
from pxr import Sdf, Usd

from casa_assets.checks.check import Package, run
from casa_assets.checks.readers.usd_facts import missing_importer
from casa_assets.checks.simready_python import NoVerdict, validator_python
from casa_assets.checks.table import TABLE
from casa_assets.formats.mjcf import document as mjcf
from casa_assets.formats.usd import document as usd
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.registry import load
from tests.support.asset.assets import category, write_to

LIMITS = load().limits


@cache  # also keeps the stage alive, without which its prims expire
def stage_of(asset: Asset) -> Usd.Stage:
    """The USD of an asset, in memory."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(usd.layer_text(asset))
    return Usd.Stage.Open(layer)


def written(asset: Asset, library: Path) -> Package:
    """Both formats of an asset below `library`."""
    thumbnail = io.BytesIO()
    Image.new("RGB", (256, 256), (128, 128, 128)).save(thumbnail, "PNG")
    root = write_to(mjcf.write(asset) | usd.write(asset, thumbnail.getvalue()), library / asset.id)
    return Package(asset, category(asset), root)


def tamper(path: Path, *changes: tuple[str, str]) -> None:
    """Replace text of a file; each text must be there."""
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text, f"{old!r} is not in {path.name}"
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def edit(text: str) -> tuple[str, str]:
    """Text of a file and what is put in its place, of `before {old|new} behind`."""
    old, new = (re.sub(r"\{(.*?)\|(.*?)\}", part, text, flags=re.DOTALL) for part in (r"\1", r"\2"))
    return old, new


def not_run_here(on_good: bool = False) -> set[str]:
    """Codes of the checks that need an optional package which this environment lacks.

    Args:
        on_good: with those that find some faults without it, and cannot pass.
    """
    found: set[str] = set()
    try:
        validator_python()
    except NoVerdict:
        found |= {"USD002", "SCN020"}
    if missing_importer():
        found |= {"USD004", "PAR001", "PAR003", "SCN018"} | ({"PAR004", "SCN017"} if on_good else set())
    return found


def tripped(package: Package, prefixes: tuple[str, ...]) -> set[str]:
    """Codes of the rows with those prefixes that find a fault."""
    rows = [check for check in TABLE if check.code.startswith(prefixes)]
    return {issue.code for issue in run(package, package.asset.id, LIMITS, table=rows).issues}


def packed(asset: Asset, folder: Path) -> Package:
    return Package(asset, category(asset), write_to(mjcf.write(asset), folder / asset.digest[:12]))


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


Tampering = Callable[[Package], None]
