"""Explain each code of a report, and print docs/reference/checks.md from that."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from casa_assets import registry
from casa_assets.checks.table import TABLE
from casa_assets.model.issue import Severity
from casa_assets.registry.plugins.checks import check_table, with_plugin_limits
from casa_assets.textures import check as texture_check
from casa_assets.textures.pack_entry import REMEDIES

HEAD = """# Checks and rejections

Printed by `./dev docs`; `casa-assets checks USD002` explains one code. A check ends as **passed**, **failed**,
**not applicable** (the subject has nothing of the kind) or **not run** (it could not look: a file does not open, an
optional package is not installed; or `waivers.yaml` waives it); the last two come with a reason. An error that failed
keeps an asset out of the library, and so does one that was not run, unless it is waived or needs an optional package. A
warning that failed is advice and is kept in `asset.json`. Where a check fails on something that this program generated
without a change of yours, please report it.
"""

# Users' words for the subjects of checks, by the names of their records: a section of the page each.
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


@dataclass(frozen=True)
class CodeFacts:
    """Meaning of a code of a report, of a check or of a reason for a rejection.

    Attributes:
        title: in a few words. severity: `error`, `warning` or `rejection`. subject: kind of object that is checked.
        limit: threshold of the check, in `unit`; None if it has none. about: what is tested and what to do.
    """

    code: str
    title: str
    severity: str
    subject: str
    limit: float | None
    unit: str
    about: str

    @property
    def row(self) -> str:
        """As a row of a Markdown table; a check is an error unless its row says otherwise."""
        mark = "" if self.severity == Severity.ERROR else f" ({self.severity})"
        return f"| {self.code} | **{self.title}**{mark}. {self.about} |"


def every_code() -> dict[str, CodeFacts]:
    """Code -> what it means: checks, those of plug-ins too, reasons for rejections, and checks of textures."""
    return {facts.code: facts for facts in (*check_facts(), *_rejections(), *_textures(), *_pictures())}


def check_facts() -> Iterator[CodeFacts]:
    """Every check of assets, kitchens and libraries, in the order of their table."""
    limits = with_plugin_limits(registry.load().limits)
    for row in check_table():
        subject, limit = SUBJECTS.get(row.subject.__name__, ""), limits[row.limit] if row.limit else None
        about = row.describe(limits)
        yield CodeFacts(row.code, row.title, row.severity.value, subject, limit, row.unit, about)


def _rejections() -> Iterator[CodeFacts]:
    for code, row in sorted(registry.load().rejections.items()):
        title = row.name.replace("_", " ").capitalize()
        yield CodeFacts(code, title, "rejection", "source file", None, "", f"{row.meaning} {row.remedy}")


def _textures() -> Iterator[CodeFacts]:
    limits, error = registry.load().limits, Severity.ERROR.value
    for row in texture_check.TABLE:
        limit = limits[row.limit]
        yield CodeFacts(row.code, row.title, error, "texture", limit, row.unit, row.description.format(limit=limit))
    for code, (title, key, about) in texture_check.SET_CHECKS.items():
        yield CodeFacts(code, title, error, "set of textures", limits[key], "", about.format(limit=limits[key]))


def _pictures() -> Iterator[CodeFacts]:
    for reason, remedy in REMEDIES.items():
        title = reason.name.replace("_", " ").capitalize()
        yield CodeFacts(reason.value, title, "rejection", "picture of a pack", None, "", remedy)


def checks_markdown() -> str:
    """The whole page: a table for each kind of subject, of rejections, and of textures; without checks of plug-ins."""
    own = {row.code for row in TABLE}
    facts = [one for one in check_facts() if one.code in own]
    lines = [HEAD.rstrip("\n")]
    for subject in dict.fromkeys(SUBJECTS.values()):
        lines += ["", f"## Checks of {subject}", "", TABLE_HEADER]
        lines += [one.row for one in facts if one.subject == subject]
    lines += ["", "## Reasons for rejections and warnings of the stages", ""]
    lines += ["| code | meaning | what to do |", "|---|---|---|"]
    for code, entry in sorted(registry.load().rejections.items()):
        lines.append(f"| {code} | {entry.meaning} | {entry.remedy} |")
    lines += ["", "## Checks of every texture", "", TABLE_HEADER, *(one.row for one in _textures())]
    lines += ["", "## Why a picture is left out of a pack", "", "| code | what to do |", "|---|---|"]
    lines += [f"| {one.code} | {one.about} |" for one in _pictures()]
    return "\n".join(lines) + "\n"
