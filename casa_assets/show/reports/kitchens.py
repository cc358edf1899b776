"""All scenes of a folder on one page, on one contact sheet, and in one table of numbers.

The table has verdict, joints, design, load time, pace and budgets of each.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from casa_assets.cache.cache_key import key_of
from casa_assets.core.system import keep_json, kept_json
from casa_assets.layouts.run.diversity import Diversity, read_diversity, table_rows
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.files import EYE_PICTURE
from casa_assets.show.page.page_template import MAX_ROWS, relative_link, render_template
from casa_assets.show.stills.pictures import SheetCell, contact_sheet

PAGE, SHEET = "index.html", "contact_sheet.png"
SUMMARY = "summary.json"
FLOOR_MAP = "floor_map.png"
CARDS = "kitchens.json"  # in the cache
# Scenes on the contact sheet: all up to the first number, of more the second number, in more columns.
MAX_ON_SHEET, SHOWN_OF_MORE = 120, 60
CELL_PX, CELL_HEIGHT_PX, SHEET_COLUMNS, COLUMNS_OF_MORE = 400, 267, 4, 6
# Heading, field, how its numbers are written; the first ones are shown where room is short.
COLUMNS: tuple[tuple[str, str, str], ...] = (
    ("joints", "joints", "d"),
    ("NKBA", "design", ".0f"),
    ("load ms", "load_ms", ".0f"),
    ("x real", "real_time_factor", ".1f"),
    ("check s", "check_s", ".1f"),
    ("geoms", "geoms", "d"),
    ("bodies", "bodies", "d"),
    ("nv", "nv", "d"),
    ("tex MB", "texture_mb", ".0f"),
    ("tasks", "tasks", "d"),
    ("access", "access", ".0f"),
)
VERDICTS = {True: "passed", False: "failed", None: "not checked"}


@dataclass(frozen=True)
class SceneRow:
    """A scene; numbers are None if no check has run.

    Attributes:
        errors: code -> number of occurrences. checks: number that passed, such as `76 of 76 that apply`.
        joints: swept through their range. design, access: scores, of 100. tasks: afforded, of 25.
        load_ms, real_time_factor, check_s: on the machine of the check. bodies and on: size of the model.
    """

    id: str
    plan: str
    style: str
    passed: bool | None = None
    errors: dict[str, int] | None = None
    checks: str = ""
    joints: int | None = None
    design: float | None = None
    access: float | None = None
    tasks: int | None = None
    load_ms: float | None = None
    real_time_factor: float | None = None
    check_s: float | None = None
    bodies: int | None = None
    geoms: int | None = None
    nv: int | None = None
    texture_mb: float | None = None

    @property
    def verdict(self) -> str:
        """One word, or the codes of what is wrong."""
        if self.passed is None:
            return "not checked"
        if self.passed:
            return "passed"
        return ", ".join(f"{code} x {n}" for code, n in sorted((self.errors or {}).items()))


def read_rows(out: Path) -> list[SceneRow]:
    """Every scene below a folder, by id."""
    return [card.row for card in read_cards(out)]


def _row(folder: Path, facts: Mapping[str, Any]) -> SceneRow:
    row = SceneRow(facts["id"], facts["plan"], facts["style"])
    path = folder / "report.json"
    if not path.is_file():
        return row
    report: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    checks = Report.model_validate({key: report[key] for key in ("subject", "results", "issues")})
    holds, speed, grade = report.get("holds", {}), report.get("speed", {}), report.get("grade", {})
    return replace(
        row,
        passed=bool(report["passed"]),
        errors=dict(Counter(issue.code for issue in checks.errors)),
        checks=str(checks.tally),
        design=grade.get("score"),
        access=grade.get("access_score"),
        tasks=sum(not t["wants"] for t in report["tasks"]),
        **{name: holds.get(name) for name in ("joints", "bodies", "geoms", "nv", "texture_mb")},
        **{name: speed.get(name) for name in ("load_ms", "real_time_factor", "check_s")},
    )


def cells(row: SceneRow) -> list[str]:
    """The numbers of a row as text, in the order of the columns."""
    values = [(getattr(row, field), form) for _, field, form in COLUMNS]
    return ["" if value is None else format(value, form) for value, form in values]


def totals(found: Sequence[SceneRow]) -> dict[str, float]:
    """Counts over all rows, and the worst and mean of what was measured; of nothing there is no mean."""
    numbers: dict[str, float] = {
        "scenes": len(found),
        "checked": sum(r.passed is not None for r in found),
        "passed": sum(bool(r.passed) for r in found),
        "joints": sum(r.joints or 0 for r in found),
    }
    worst_of = {"design": min, "load_ms": max, "real_time_factor": min, "check_s": max, "texture_mb": max}
    for field, worst in worst_of.items():
        values = [v for r in found if (v := getattr(r, field)) is not None]
        if values:
            numbers[f"{field}_mean"] = round(sum(values) / len(values), 2)
            numbers[f"{field}_worst"] = round(worst(values), 2)
    return numbers


def sentence(found: Sequence[SceneRow]) -> str:
    """The totals in words."""
    t = totals(found)
    message = f"{t['passed']:.0f} of {t['checked']:.0f} checked scenes passed, {t['joints']:.0f} joints swept"
    if "design_mean" in t:
        message += f"; NKBA {t['design_mean']:.0f} on average, {t['design_worst']:.0f} at worst"
    if "check_s_mean" in t:
        message += f"; check {t['check_s_mean']:.1f} s, {t['check_s_worst']:.1f} at worst"
    if "load_ms_mean" in t:
        message += f"; load {t['load_ms_mean']:.0f} ms, {t['load_ms_worst']:.0f} at worst"
        message += f"; {t['real_time_factor_mean']:.1f} x real time, {t['real_time_factor_worst']:.1f} at worst"
    return message


@dataclass(frozen=True)
class SceneCard:
    """A scene as the page shows it.

    Attributes:
        families: of its fixtures, except floor, walls and ceiling. tasks: names of the atomic tasks that it affords.
        surfaces: ids of its finishes. pictures: names of its files, the one that shows most of it first.
    """

    row: SceneRow
    fixtures: int
    joints: int
    objects: int = 0
    families: tuple[str, ...] = ()
    tasks: tuple[str, ...] = ()
    surfaces: tuple[str, ...] = ()
    floor_m2: float = 0.0
    pictures: tuple[str, ...] = ()


def _card(folder: Path) -> SceneCard:
    facts = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    things = [fixture for fixture in facts["fixtures"] if fixture.get("layer") == "things"]
    tasks = {**facts.get("tasks", {}), **facts.get("robocasa_v1", {})}
    # The overview, then others by name; the map of its floor last.
    pictures = sorted(
        (path.name for path in folder.glob("*.png")), key=lambda name: (name == FLOOR_MAP, name != "overview.png", name)
    )
    (x0, y0, _), (x1, y1, _) = facts["room"]["bounds"]
    return SceneCard(
        _row(folder, facts),
        len(facts["fixtures"]),
        sum(len(f["joints"]) for f in facts["fixtures"]),
        objects=len(facts.get("objects", ())),
        families=tuple(sorted({str(fixture["family"]) for fixture in things})),
        tasks=tuple(sorted(name for name, task in tasks.items() if task.get("afforded"))),
        surfaces=tuple(sorted({str(name) for name in facts.get("surfaces", {}).values()})),
        floor_m2=round((x1 - x0) * (y1 - y0), 2),
        pictures=tuple(pictures),
    )


def read_cards(out: Path) -> list[SceneCard]:
    """Every scene below a folder, by id; one whose files have not changed is taken from `.casa/cache/kitchens.json`."""
    kept_at, made_by, adapter = out / ".casa" / "cache" / CARDS, key_of(_card), TypeAdapter(SceneCard)
    try:
        kept = kept_json(kept_at)
        known = kept["scenes"] if kept["made_by"] == made_by else {}
    except (KeyError, TypeError):
        known = {}
    cards, fresh = [], {}
    for path in sorted(out.glob("*/scene.json")):
        folder, state = path.parent, _state(path.parent)
        found = known.get(folder.name)
        if isinstance(found, dict) and found.get("state") == state:
            card = adapter.validate_python(found["card"])
        else:
            card = _card(folder)
        cards.append(card)
        fresh[folder.name] = {"state": state, "card": asdict(card)}
    keep_json(kept_at, {"made_by": made_by, "scenes": fresh})  # a folder that may only be read is read again each time
    return cards


def _state(folder: Path) -> str:
    """Return a text that changes whenever a file that a card is made from is added, removed or rewritten."""
    files = sorted((*folder.glob("*.json"), *folder.glob("*.png")))
    return " ".join(f"{path.name}:{path.stat().st_mtime_ns}:{path.stat().st_size}" for path in files)


def write(out: Path, heading: str = "Kitchens") -> tuple[Path, Path]:
    """Write page, contact sheet and table of all scenes in a folder; returns the paths of page and sheet."""
    found = read_cards(out)
    rows = [card.row for card in found]
    text = json.dumps({"totals": totals(rows), "scenes": [asdict(row) for row in rows]}, indent=1, sort_keys=True)
    (out / SUMMARY).write_text(text + "\n", encoding="utf-8")
    shown = on_sheet(found)
    shots = []
    for card in shown:
        name, about = best_picture(card), f"{card.fixtures} fixtures, {card.joints} joints, {card.row.verdict}"
        shots.append(SheetCell(card.row.id, about, (out / card.row.id / name).read_bytes() if name else b""))
    picture, page = out / SHEET, out / PAGE
    is_all = len(shown) == len(found)
    count = f"{len(found):,}" if is_all else f"{len(shown)} of {len(found):,}"
    columns = SHEET_COLUMNS if is_all else COLUMNS_OF_MORE
    picture.write_bytes(contact_sheet(shots, f"{heading}: {count}", columns, CELL_PX, CELL_HEIGHT_PX))
    page.write_text(index_page(found, heading, read_diversity(out)), encoding="utf-8")
    return page, picture


def on_sheet(found: Sequence[SceneCard]) -> list[SceneCard]:
    """The scenes that the contact sheet shows: all, or of many some at even distances in the list, of all plans."""
    if len(found) <= MAX_ON_SHEET:
        return list(found)
    pictured = [card for card in found if card.pictures] or list(found)
    count = min(SHOWN_OF_MORE, len(pictured))
    return [pictured[i * len(pictured) // count] for i in range(count)]


def best_picture(card: SceneCard) -> str:
    """Return the name of the most informative picture: at eye level with doors open, else the first, else empty."""
    first = card.pictures[0] if card.pictures else ""
    return EYE_PICTURE if EYE_PICTURE in card.pictures else first


def _index_row(card: SceneCard, places: Mapping[str, int]) -> dict[str, Any]:
    row = card.row
    return {
        "id": row.id,
        "plan": row.plan,
        "style": row.style,
        "verdict": VERDICTS[row.passed],
        "errors": "" if row.passed is not False else row.verdict,
        "fixtures": card.fixtures,
        "joints": card.joints,
        "objects": card.objects,
        "families": [places[name] for name in card.families],
        "tasks": [places[name] for name in card.tasks],
        "surfaces": list(card.surfaces),
        "floor": card.floor_m2,
        "design": row.design,
        "access": row.access,
        "load": row.load_ms,
        "pace": row.real_time_factor,
        "folder": relative_link(row.id),
        "pictures": list(card.pictures),
    }


def index_page(found: Sequence[SceneCard], heading: str, diversity: tuple[Diversity, Diversity] | None = None) -> str:
    """HTML of the page for finding a kitchen; `diversity`: of those drawn at random, and of the reference."""
    shown, sums = found[:MAX_ROWS], totals([card.row for card in found])
    # Families and tasks, once each: a page of thousands would repeat them thousands of times.
    names = sorted({name for card in shown for name in (*card.families, *card.tasks)})
    places = {name: i for i, name in enumerate(names)}
    data = {"names": names, "rows": [_index_row(card, places) for card in shown]}
    return render_template(
        "kitchens/index.html",
        title=heading,
        sentence="{passed:,.0f} of {checked:,.0f} checked kitchens passed, {joints:,.0f} joints swept".format(**sums),
        count=len(found),
        unchecked=sum(card.row.passed is None for card in found),
        numbers=SUMMARY,
        sheet=SHEET,
        diversity=table_rows(*diversity) if diversity else (),
        data=data,
        styles=("browse/browse.css", "kitchens/index.css"),
        scripts=("browse/browse.js", "kitchens/index.js"),
    )
