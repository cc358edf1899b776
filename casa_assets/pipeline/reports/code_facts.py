"""What each code of a report means, for those who look one up."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from casa_assets import registry
from casa_assets.model.issue import Severity
from casa_assets.pipeline.reports.checks_page import SUBJECTS
from casa_assets.registry.plugins.checks import check_table, with_plugin_limits
from casa_assets.textures import check as texture_check
from casa_assets.textures.packs.rejections import REMEDIES


@dataclass(frozen=True)
class CodeFacts:
    """What a code of a report means.

    Attributes:
        code: such as `USD002`. title: what is tested, or why an input was rejected, in a few words.
        severity: `error`, `warning` or `rejection`. subject: what is looked at.
        limit: the number that decides, None where there is none. unit: of it.
        about: what is tested and what to do, sentences.
    """

    code: str
    title: str
    severity: str
    subject: str
    limit: float | None
    unit: str
    about: str


def every_code() -> dict[str, CodeFacts]:
    """Code -> what it means: checks, those of plug-ins too, reasons for rejections, and checks of textures."""
    return {facts.code: facts for facts in (*check_facts(), *_rejections(), *_textures())}


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
    for reason, remedy in REMEDIES.items():
        title = reason.name.replace("_", " ").capitalize()
        yield CodeFacts(reason.value, title, "rejection", "picture of a pack", None, "", remedy)
