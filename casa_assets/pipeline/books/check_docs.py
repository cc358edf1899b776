"""docs/checks.md, printed from the table of checks and the registry."""

from __future__ import annotations

from casa_assets import registry
from casa_assets.checks.table import TABLE
from casa_assets.textures import check as texture_check
from casa_assets.textures.packs.faults import MEND

HEAD = """# Checks and rejections

Printed by `./dev docs` from the table in `casa_assets/checks/table.py`, `registry/limits.yaml` and
`registry/rejections.yaml`. An asset with an error is not in the library; a warning is kept in its `asset.json`.

## Checks on every asset

| code | severity | looks at | limit | why it matters |
|---|---|---|---|---|
"""


def markdown() -> str:
    """The whole page."""
    known = registry.load()
    lines = [HEAD.rstrip("\n")]
    for row in TABLE:
        limit = f"{known.limits[row.limit]:g} {row.unit}".strip() if row.limit else ""
        lines.append(f"| {row.code} | {row.severity.value} | {row.subject.__name__} | {limit} | {row.why} |")
    lines += ["", "## Reasons for rejections and warnings of the stages", "", "| code | name | meaning | what to do |"]
    lines.append("|---|---|---|---|")
    for code, entry in sorted(known.rejections.items()):
        lines.append(f"| {code} | {entry.name} | {entry.meaning} | {entry.mend} |")
    lines += _textures(known)
    return "\n".join(lines) + "\n"


def _textures(known: registry.Registry) -> list[str]:
    """Checks of textures, and why a picture is left out of a pack."""
    lines = ["", "## Checks on every texture", "", "| code | limit | what is wrong where it fails |", "|---|---|---|"]
    for row in texture_check.TABLE:
        bound = "at most" if row.most else "at least"
        lines.append(f"| {row.code} | {bound} {known.limits[row.limit]:g} {row.unit}".rstrip() + f" | {row.why} |")
    lines += [f"| {code} | | {why} |" for code, why in texture_check.OF_SETS.items()]
    lines += ["", "## Why a picture is left out of a pack", "", "| code | name | what to do |", "|---|---|---|"]
    lines += [f"| {fault.value} | {fault.name.lower()} | {mend} |" for fault, mend in MEND.items()]
    return lines


def codes() -> frozenset[str]:
    """Every code that the page explains."""
    known = {*registry.load().rejections, *(row.code for row in TABLE), *(row.code for row in texture_check.TABLE)}
    return frozenset(known | texture_check.OF_SETS.keys() | {fault.value for fault in MEND})
