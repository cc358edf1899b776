"""The report on a library as one HTML page that opens from disk and needs no network."""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from casa_assets.core.rounding import significant
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.issue import CheckResult, Issue, Severity, Status, Tally, tally
from casa_assets.model.record import Vec3
from casa_assets.pipeline.reports.page_template import relative_link, render_template

# No section on the library as a whole.
NO_SECTION = Markup()
# Status of a check -> what the script of the page knows it by.
STATUS_NUMBERS = {Status.FAILED: 0, Status.PASSED: 1, Status.NOT_APPLICABLE: 2, Status.NOT_RUN: 3}


@dataclass(frozen=True)
class AssetRow:
    """One accepted asset.

    Attributes:
        id, category: as in the asset.
        folder: its folder, POSIX, relative to the page.
        files: (label, path relative to the folder) of what is linked to, such as (`MJCF`, `model.xml`).
        extents_m: full size (x, y, z), metres.
        mass_kg: of the whole asset.
        colliders: number of collision shapes. hull_max_vertices: of the largest hull, 0 without one.
        faces: triangles of all visuals.
        source, source_path, licence, author, title, uri: where it comes from, as its provenance states it.
        warnings: issues that did not keep it out.
        results: one per check, also of those that do not apply or were not run.
        guesses: what was decided without being stated.
        looks: what its pictures look like to a model, a sentence; empty where nobody looked.
        thumbnail: WebP, empty where there is no picture. preview_path: of the picture, relative to the folder.
    """

    id: str
    category: str
    folder: str
    files: tuple[tuple[str, str], ...]
    extents_m: Vec3
    mass_kg: float
    colliders: int
    hull_max_vertices: int
    faces: int
    source: str
    source_path: str
    licence: str
    author: str = ""
    title: str = ""
    uri: str = ""
    warnings: tuple[Issue, ...] = ()
    results: tuple[CheckResult, ...] = ()
    guesses: tuple[Guess, ...] = ()
    looks: str = ""
    thumbnail: bytes = b""
    preview_path: str = ""


@dataclass(frozen=True)
class RejectedRow:
    """One input that was not accepted.

    Attributes:
        path: of the input, relative to its source.
        source: kind of source.
        code: such as `SRC003`. meaning: what the code stands for, one line.
        reason: what was wrong with this input. mend: what to do about it.
        category: as far as it was known.
        results: of the checks; the failed ones are shown.
        thumbnail: WebP of the raw model, empty where it could not be drawn.
    """

    path: str
    source: str
    code: str
    meaning: str
    reason: str
    mend: str
    category: str = ""
    results: tuple[CheckResult, ...] = ()
    thumbnail: bytes = b""


def render_page(
    entries: Sequence[AssetRow],
    rejects: Sequence[RejectedRow],
    title: str,
    why: Mapping[str, str] | None = None,
    whole: Markup = NO_SECTION,
) -> str:
    """The page: assets by id, rejected inputs by path; the same records give the same page.

    Args:
        entries: accepted assets.
        rejects: inputs that were turned away.
        title: heading, plain text.
        why: code of a check to its title and what is tested.
        whole: HTML of the section on all assets together, see `library_section.section`.
    """
    entries = sorted(entries, key=lambda e: e.id)
    rejects = sorted(rejects, key=lambda r: (r.path, r.code))
    ran = [*(e.results for e in entries), *(r.results for r in rejects)]
    codes = sorted({(result.code, result.unit) for results in ran for result in results})
    number = {code: i for i, code in enumerate(codes)}
    advice = {result.code for results in ran for result in results if result.severity is Severity.WARNING}
    data = {
        "checks": [[code, unit, (why or {}).get(code, ""), code in advice] for code, unit in codes],
        "assets": [_asset(e, number) for e in entries],
        "rejects": [_reject(r, number) for r in rejects],
    }
    return render_template(
        "library.html",
        title=title,
        tiles=_tiles(entries, rejects),
        whole=whole,
        data=data,
        style="library.css",
        script="library.js",
    )


def _tiles(entries: Sequence[AssetRow], rejects: Sequence[RejectedRow]) -> list[dict[str, str]]:
    """The numbers at the top, which are readable without scripts too."""
    warned = sum(1 for e in entries if e.warnings)
    told = tally(r for e in entries for r in e.results)
    read = len(entries) + len(rejects)
    share = f"{100.0 * len(entries) / read:.3g} % of {read:,} inputs" if read else "nothing was read"
    reasons = len({r.code for r in rejects})
    tiles = [
        ("accepted", "Accepted", f"{len(entries):,}", share),
        ("rejected", "Rejected", f"{len(rejects):,}", f"for {_count(reasons, 'reason')}"),
        ("warned", "With warnings", f"{warned:,}", _count(sum(len(e.warnings) for e in entries), "warning")),
        ("checks", "Checks passed", f"{told.passed:,}", _of(told)),
        ("categories", "Categories", f"{len({e.category for e in entries}):,}", _largest(entries)),
        ("mass", "Total mass", f"{sum(e.mass_kg for e in entries):.4g} kg", "of all accepted"),
    ]
    return [dict(zip(("key", "label", "value", "note"), tile, strict=True)) for tile in tiles]


def _of(told: Tally) -> str:
    """Note beside the number of checks that passed."""
    parts = [f"of {told.applying:,} that apply"]
    if told.not_run:
        parts.append(f"{told.not_run:,} not run")
    return ", ".join(parts)


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def _largest(entries: Sequence[AssetRow]) -> str:
    """The category with most assets, the first by name where several have as many."""
    counts = Counter(e.category for e in entries)
    if not counts:
        return "none"
    name, number = min(counts.items(), key=lambda item: (-item[1], item[0]))
    return f"most: {name} ({number:,})"


def _asset(entry: AssetRow, number: dict[tuple[str, str], int]) -> dict[str, Any]:
    return {
        "id": entry.id,
        "category": entry.category,
        "size": [round(100.0 * side, 3) for side in entry.extents_m],
        "mass": _short(entry.mass_kg),
        "colliders": entry.colliders,
        "hull": entry.hull_max_vertices,
        "faces": entry.faces,
        "source": entry.source,
        "path": entry.source_path,
        "licence": entry.licence,
        "author": entry.author,
        "title": entry.title,
        "uri": entry.uri,
        "warnings": [[i.code, i.pointer, i.message] for i in entry.warnings],
        "results": [
            [number[r.code, r.unit], STATUS_NUMBERS[r.status], _short(r.number), _short(r.limit), r.reason]
            for r in entry.results
        ],
        "looks": entry.looks,
        "guesses": [[g.subject, g.value, _short(g.confidence), g.reason] for g in entry.guesses],
        "files": [[label, _link(entry.folder, path)] for label, path in entry.files],
        "large": _link(entry.folder, entry.preview_path) if entry.preview_path else "",
        "thumb": _data_uri(entry.thumbnail),
    }


def _reject(entry: RejectedRow, number: dict[tuple[str, str], int]) -> dict[str, Any]:
    return {
        "path": entry.path,
        "source": entry.source,
        "code": entry.code,
        "meaning": entry.meaning,
        "reason": entry.reason,
        "mend": entry.mend,
        "category": entry.category,
        "failed": [
            [number[r.code, r.unit], _short(r.number), _short(r.limit)]
            for r in entry.results
            if r.status is Status.FAILED
        ],
        "thumb": _data_uri(entry.thumbnail),
    }


def _data_uri(webp: bytes) -> str:
    return f"data:image/webp;base64,{base64.b64encode(webp).decode('ascii')}" if webp else ""


def _link(folder: str, path: str) -> str:
    parts: Iterable[str] = (part for part in (folder, path) if part)
    return relative_link("/".join(parts))


def _short(number: float | None) -> float | None:
    """Round to six digits, which are enough to read and keep the page small."""
    return None if number is None else significant(number, 6)
