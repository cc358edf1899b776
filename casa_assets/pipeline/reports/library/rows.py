"""Rows and details of the entries of a library, as the script of the page reads them."""

from __future__ import annotations

import base64
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from casa_assets.core.rounding import significant
from casa_assets.model.issue import CheckResult, Decision, Severity, Status
from casa_assets.model.registry.rows import Rejection
from casa_assets.pipeline.ingest.refused_rows import NAME as ROWS
from casa_assets.pipeline.library.library import CERTIFICATE, REFUSAL
from casa_assets.pipeline.reports.entry import Entry, Reported
from casa_assets.pipeline.reports.page_template import relative_link

# Status of a check -> what the script of the page knows it by; a failed warning is advice.
STATUS_NUMBERS = {Status.FAILED: 0, Status.PASSED: 1, Status.NOT_APPLICABLE: 2, Status.NOT_RUN: 3}
ADVICE_NUMBER = 4
# Entries in one part of the page's data: rows are all loaded, details and pictures as they are needed.
PART_SIZES = {"rows": 2000, "details": 40, "pictures": 40}
# Files of an asset that the page links to, relative to its folder.
FILES = (("MJCF", "model.xml"), ("scene", "scene.xml"), ("USD", "usd/{id}.usda"), ("certificate", CERTIFICATE))
# What to do where a reason says nothing about it.
DEFAULT_ADVICE = "Look at the picture and the numbers, and fix the mesh."
# Values of a row, in their order; what the words mean stands in docs/reference/report.md.
FIELDS = (
    "id",
    "verdict",
    "category",
    "title",
    "source",
    "path",
    "licence",
    "author",
    "size",
    "mass",
    "colliders",
    "faces",
    "passed",
    "applying",
    "codes",
    "decide",
    "outlier",
    "change",
    "folder",
)
# Values that follow where a page has no details beside its rows.
BRIEF_FIELDS = ("message",)


@dataclass(frozen=True)
class RowContext:
    """What a row tells beside its entry.

    Attributes:
        folder: from the page to the library, POSIX, such as `.`.
        size_outliers, mass_outliers: ids of assets outside the usual ranges.
        changes: id -> how it does beside an earlier run.
    """

    folder: str
    size_outliers: Collection[str] = ()
    mass_outliers: Collection[str] = ()
    changes: Mapping[str, str] | None = None

    def link(self, path: str) -> str:
        """Link from the page to something in the library."""
        return relative_link(path if self.folder == "." else f"{self.folder}/{path}")

    def outlier_of(self, entry_id: str) -> list[str]:
        """Quantities in which it is outside the usual range."""
        return [name for name, ids in (("size", self.size_outliers), ("mass", self.mass_outliers)) if entry_id in ids]


def row_of(entry: Reported, context: RowContext) -> list[Any]:
    """Values of FIELDS; size in centimetres, mass in kg, None for a rejected input.

    `codes` are what it was rejected for, or the advice that it has; `decide` what a person has to decide.
    """
    summary = entry.summary
    return [
        entry.id,
        entry.decision.value,
        entry.category,
        entry.title,
        entry.source,
        entry.source_path,
        entry.licence,
        entry.author,
        [round(100.0 * side, 3) for side in summary.extents] if summary else None,
        _short(summary.mass) if summary else None,
        summary.colliders if summary else None,
        summary.faces if summary else None,
        entry.checks.passed,
        entry.checks.applying,
        list(codes_of(entry)),
        sorted(set(entry.to_decide)),
        context.outlier_of(entry.id),
        (context.changes or {}).get(entry.id, ""),
        context.link(entry.path),
    ]


def brief_row_of(entry: Reported, context: RowContext) -> list[Any]:
    """Values of FIELDS and BRIEF_FIELDS."""
    return [*row_of(entry, context), entry.message]


def codes_of(entry: Reported) -> tuple[str, ...]:
    """What an entry was rejected for, or the advice that it has."""
    if entry.accepted:
        return entry.advice
    return (entry.code,) if entry.code else ()


@dataclass(frozen=True)
class Words:
    """What codes mean.

    Attributes:
        rejections: reasons of the stages. explanations: code of a check -> its title and what is tested.
    """

    rejections: Mapping[str, Rejection]
    explanations: Mapping[str, str]

    def meaning(self, code: str) -> str:
        """What a code stands for; empty for an unknown one."""
        rejection = self.rejections.get(code)
        return rejection.meaning if rejection else self.explanations.get(code, "")

    def needs_nothing(self, code: str) -> bool:
        """True where a code tells what was done to an input, and its remedy says that nothing has to follow."""
        rejection = self.rejections.get(code)
        return rejection is not None and rejection.remedy.startswith("Nothing")

    def reason_and_fix(self, entry: Entry) -> tuple[str, str]:
        """What was wrong with a rejected input, and what to do about it."""
        rejection = self.rejections.get(entry.code)
        if rejection:
            return entry.message, rejection.remedy
        # The message of a check ends with what to do.
        fault, _, fix = entry.message.partition("; ")
        return (f"{fault}.", f"{fix[:1].upper()}{fix[1:]}.") if fix else (entry.message, DEFAULT_ADVICE)


def details_of(entry: Entry, words: Words, looks: str) -> dict[str, Any]:
    """What the page tells of an entry that is opened; the entry has the results of its checks.

    Args:
        looks: what its pictures look like to a model, a sentence; empty where nobody looked.
    """
    told: dict[str, Any] = {
        "results": [
            [r.code, _status_number(r), _short(r.number), _short(r.limit), r.unit, r.reason] for r in entry.results
        ],
    }
    if entry.decision is Decision.REJECTED:
        told["reason"], told["fix"] = words.reason_and_fix(entry)
        # Refused rows of a manifest share one file and have no folder.
        told["files"] = [] if entry.path.endswith(f"/{ROWS}") else [["reason", relative_link(REFUSAL)]]
        return told
    return told | {
        "hull": entry.summary.hull_vertices if entry.summary else 0,
        "uri": entry.uri,
        "prompt": entry.prompt,
        "generator": entry.generator,
        "looks": looks,
        "warnings": [[issue.code, issue.pointer, issue.message] for issue in entry.warnings],
        "guesses": [[g.subject, g.value, _short(g.confidence), g.reason] for g in entry.guesses],
        "files": [[label, relative_link(path.format(id=entry.id))] for label, path in FILES],
    }


def _status_number(result: CheckResult) -> int:
    is_advice = result.status is Status.FAILED and result.severity is Severity.WARNING
    return ADVICE_NUMBER if is_advice else STATUS_NUMBERS[result.status]


def data_uri(webp: bytes) -> str:
    """A picture as text that a page can show; empty for none."""
    return f"data:image/webp;base64,{base64.b64encode(webp).decode('ascii')}" if webp else ""


def _short(number: float | None) -> float | None:
    """Round to six digits, which are enough to read and keep the page small."""
    return None if number is None else significant(number, 6)
