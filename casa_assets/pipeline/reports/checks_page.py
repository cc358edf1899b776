"""docs/reference/checks.md, printed from the table of checks and the registry."""

from __future__ import annotations

from casa_assets import registry
from casa_assets.checks.table.table import TABLE
from casa_assets.textures import check as texture_check
from casa_assets.textures.packs.rejections import REMEDIES

HEAD = """# Checks and rejections

Printed by `./dev docs` from the tables in `casa_assets/checks/table/`, `registry/limits.yaml` and
`registry/rejections.yaml`. A check ends in one of four ways: **passed**; **failed**; **not applicable**, where the
subject has nothing of the kind (no joint, no picture); **not run**, where it could not look (a file does not open, no
weights were given) or `registry/waivers.yaml` waives it. The last two come with a reason. An asset is kept out of the
library by an error that failed, and by an error that was not run, unless it is waived. A warning that failed is advice
and is kept in its `asset.json`. What to do is written for whoever makes the mesh, the family or the plan; where a
check fails on something that this program generated without a change of yours, please report it.

## Checks

| code | title | severity | looks at | limit | what is tested, and what to do |
|---|---|---|---|---|---|
"""

# What a user calls the subjects of checks, by the names of their records.
SUBJECTS = {
    "Asset": "asset",
    "Package": "files of an asset",
    "ObjectMember": "object",
    "ObjectCollection": "objects of a library",
    "LibraryView": "library",
    "LibrarySizes": "library",
    "SceneSubject": "kitchen",
    "SceneFiles": "files of a kitchen",
    "PreviewImages": "pictures of a kitchen",
    "MeasuredSpeed": "speed of a kitchen",
    "DesignSubject": "design of a kitchen",
    "SceneRobots": "robots in a kitchen",
    "StatesSubject": "start states",
    "BatchSubject": "batch form of a kitchen",
    "EngineSizes": "batch form in use",
}
TEXTURE_TABLE_HEADER = "| code | title | limit | what is tested, and what to do |"


def checks_markdown() -> str:
    """The whole page."""
    records = registry.load()
    lines = [HEAD.rstrip("\n")]
    for row in TABLE:
        limit = f"{records.limits[row.limit]:g} {row.unit}".strip() if row.limit else ""
        cells = (
            row.code,
            row.title,
            row.severity.value,
            SUBJECTS[row.subject.__name__],
            limit,
            row.describe(records.limits),
        )
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", "## Reasons for rejections and warnings of the stages", "", "| code | name | meaning | what to do |"]
    lines.append("|---|---|---|---|")
    for code, entry in sorted(records.rejections.items()):
        lines.append(f"| {code} | {entry.name} | {entry.meaning} | {entry.remedy} |")
    lines += _texture_sections(records)
    return "\n".join(lines) + "\n"


def _texture_sections(records: registry.Registry) -> list[str]:
    """Checks of textures, and why a picture is left out of a pack."""
    lines = ["", "## Checks on every texture", "", TEXTURE_TABLE_HEADER, "|---|---|---|---|"]
    for row in texture_check.TABLE:
        bound = "at most" if row.most else "at least"
        value = records.limits[row.limit]
        limit = f"{bound} {value:g} {row.unit}".rstrip()
        lines.append(f"| {row.code} | {row.title} | {limit} | {row.description.format(limit=value)} |")
    for code, (title, key, description) in texture_check.SET_CHECKS.items():
        value = records.limits[key]
        lines.append(f"| {code} | {title} | at least {value:g} | {description.format(limit=value)} |")
    lines += ["", "## Why a picture is left out of a pack", "", "| code | name | what to do |", "|---|---|---|"]
    lines += [f"| {reason.value} | {reason.name.lower()} | {remedy} |" for reason, remedy in REMEDIES.items()]
    return lines


def codes() -> frozenset[str]:
    """Every code that the page explains."""
    explained = {*registry.load().rejections, *(row.code for row in TABLE), *(row.code for row in texture_check.TABLE)}
    return frozenset(explained | texture_check.SET_CHECKS.keys() | {reason.value for reason in REMEDIES})
