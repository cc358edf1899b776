"""docs/reference/checks.md, printed from the table of checks and the registry."""

from __future__ import annotations

from casa_assets import registry
from casa_assets.checks.table.table import TABLE
from casa_assets.textures import check as texture_check
from casa_assets.textures.packs.rejections import REMEDIES

HEAD = """# Checks and rejections

Printed by `./dev docs`; `casa-assets checks USD002` explains one code. A check ends as **passed**, **failed**,
**not applicable** (the subject has nothing of the kind) or **not run** (it could not look: a file does not open, an
optional package is not installed; or `waivers.yaml` waives it); the last two come with a reason. An error that failed
keeps an asset out of the library, and so does one that was not run, unless it is waived or needs an optional package. A
warning that failed is advice and is kept in `asset.json`. Where a check fails on something that this program generated
without a change of yours, please report it.
"""

# What a user calls the subjects of checks, by the names of their records: a section of the page each.
SUBJECTS = {
    "Asset": "assets",
    "Package": "files of assets",
    "ObjectMember": "objects",
    "ObjectCollection": "objects of one library",
    "LibraryView": "libraries",
    "LibrarySizes": "libraries",
    "SceneSubject": "kitchens",
    "SceneFiles": "files of kitchens",
    "PreviewImages": "pictures of kitchens",
    "MeasuredSpeed": "speed of kitchens",
    "DesignSubject": "design of kitchens",
    "SceneRobots": "robots in kitchens",
    "StatesSubject": "start states",
    "BatchSubject": "batch forms",
    "EngineSizes": "batch forms in use",
}
TABLE_HEADER = "| code | what is tested; what to do |\n|---|---|"


def checks_markdown() -> str:
    """The whole page: a table for each kind of subject, of rejections, and of textures."""
    records = registry.load()
    lines = [HEAD.rstrip("\n")]
    for subject in dict.fromkeys(SUBJECTS.values()):
        lines += ["", f"## Checks of {subject}", "", TABLE_HEADER]
        rows = (row for row in TABLE if SUBJECTS[row.subject.__name__] == subject)
        lines += [_row(row.code, row.title, row.severity.value, row.describe(records.limits)) for row in rows]
    lines += ["", "## Reasons for rejections and warnings of the stages", ""]
    lines += ["| code | meaning | what to do |", "|---|---|---|"]
    for code, entry in sorted(records.rejections.items()):
        lines.append(f"| {code} | {entry.meaning} | {entry.remedy} |")
    lines += _texture_sections(records)
    return "\n".join(lines) + "\n"


def _row(code: str, title: str, severity: str, told: str) -> str:
    """A row of a table; a check is an error unless its row says otherwise."""
    mark = "" if severity == "error" else f" ({severity})"
    return f"| {code} | **{title}**{mark}. {told} |"


def _texture_sections(records: registry.Registry) -> list[str]:
    """Checks of textures, and why a picture is left out of a pack."""
    lines = ["", "## Checks of every texture", "", TABLE_HEADER]
    for row in texture_check.TABLE:
        lines.append(_row(row.code, row.title, "error", row.description.format(limit=records.limits[row.limit])))
    for code, (title, key, description) in texture_check.SET_CHECKS.items():
        lines.append(_row(code, title, "error", description.format(limit=records.limits[key])))
    lines += ["", "## Why a picture is left out of a pack", "", "| code | what to do |", "|---|---|"]
    lines += [f"| {reason.value} | {remedy} |" for reason, remedy in REMEDIES.items()]
    return lines


def codes() -> frozenset[str]:
    """Every code that the page explains."""
    explained = {*registry.load().rejections, *(row.code for row in TABLE), *(row.code for row in texture_check.TABLE)}
    return frozenset(explained | texture_check.SET_CHECKS.keys() | {reason.value for reason in REMEDIES})
