"""The page of review: one asset after the other, with what was guessed and why, and keys to decide."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from casa_assets import registry
from casa_assets.model.ingest.user_override import UpAxis
from casa_assets.pipeline.library import review
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.reports.page_template import render_template


def render_page(waiting: Sequence[Entry], decided: Mapping[str, Mapping[str, str]], title: str) -> str:
    """HTML of the page.

    Args:
        waiting: what a person has to decide about, in the order in which it is shown.
        decided: sha256 of an input -> cells of its row in review.csv, by column.
        title: heading, plain text.
    """
    data = {
        "rows": [_row(number, entry, decided.get(entry.sha256, {})) for number, entry in enumerate(waiting)],
        "categories": sorted(registry.load().categories),
        "ups": [axis.value for axis in UpAxis],
    }
    return render_template(
        "review/page.html",
        title=title,
        count=len(waiting),
        data=data,
        without_scripts="review.csv of the library",
        scripts=("review/common.js", "review/page.js"),
    )


def _row(number: int, entry: Entry, cells: Mapping[str, str]) -> dict[str, Any]:
    return {
        "number": number,
        "sha256": entry.sha256,
        "id": entry.id,
        "input": entry.source_path,
        "category": entry.category,
        "size_m": [] if entry.summary is None else [round(v, 4) for v in entry.summary.extents],
        "mass_kg": None if entry.summary is None else entry.summary.mass,
        "rejected": f"{entry.code}: {entry.message}" if entry.code else "",
        "decide": list(entry.to_decide),
        "guesses": [
            [g.subject, g.value, g.confidence, g.reason] for g in entry.guesses if g.subject in review.SUBJECTS
        ],
        "set": {name: cells.get(f"set_{name}", "") for name in review.OVERRIDE_NAMES},
    }
