"""All scenes of a folder on one page, on one contact sheet, and in one table of numbers.

The table has verdict, joints, design, load time, pace and budgets of each.
"""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from PIL import Image

from casa_assets.model.issue import Report
from casa_assets.pipeline.reports.page_template import render_template
from casa_assets.preview.sheet import SheetCell, contact_sheet

PAGE, SHEET = "index.html", "contact_sheet.png"
SUMMARY, SUMMARY_PAGE = "summary.json", "summary.html"
CELL_PX, SHEET_COLUMNS = 360, 4
PAPER = (244, 244, 245)
# Verdict of a scene -> class of the style sheet.
VERDICT_STYLES = {True: "passed", False: "failed", None: "open"}


@dataclass(frozen=True)
class SceneRow:
    """A scene; numbers are None where no check has run.

    Attributes:
        id, plan, style: names. passed: verdict. errors: code -> how often.
        checks: how many passed, such as `76 of 76 that apply`.
        joints: that were swept through their range. design, access: scores, of 100. tasks: afforded, of 25.
        load_ms, real_time_factor: on the machine of the check. check_s: seconds that the check took there.
        bodies, geoms, nv, texture_mb: what the model holds.
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
        return (
            "passed" if self.passed else ", ".join(f"{code} x {n}" for code, n in sorted((self.errors or {}).items()))
        )


# Heading, field, how its numbers are written; the first ones are told where room is short.
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


def read_rows(out: Path) -> list[SceneRow]:
    """Every scene below a folder, by id."""
    return [_row(path.parent) for path in sorted(out.glob("*/scene.json"))]


def _row(folder: Path) -> SceneRow:
    facts = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    row = SceneRow(facts["id"], facts["plan"], facts["style"])
    path = folder / "report.json"
    if not path.is_file():
        return row
    report: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    errors: dict[str, int] = {}
    checks = Report.model_validate({key: report[key] for key in ("subject", "results", "issues")})
    for issue in checks.errors:
        errors[issue.code] = errors.get(issue.code, 0) + 1
    holds, speed, grade = report.get("holds", {}), report.get("speed", {}), report.get("grade", {})
    return SceneRow(
        row.id,
        row.plan,
        row.style,
        passed=bool(report["passed"]),
        errors=errors,
        checks=str(checks.tally),
        joints=holds.get("joints"),
        design=grade.get("score"),
        access=grade.get("access_score"),
        tasks=sum(not t["wants"] for t in report["tasks"]),
        load_ms=speed.get("load_ms"),
        real_time_factor=speed.get("real_time_factor"),
        check_s=speed.get("check_s"),
        bodies=holds.get("bodies"),
        geoms=holds.get("geoms"),
        nv=holds.get("nv"),
        texture_mb=holds.get("texture_mb"),
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


def write_summary(out: Path) -> list[SceneRow]:
    """Write summary.json and summary.html of all scenes in a folder; returns their rows."""
    found = read_rows(out)
    data = {"totals": totals(found), "scenes": [asdict(row) for row in found]}
    text = json.dumps(data, indent=1, sort_keys=True)
    (out / SUMMARY).write_text(text + "\n", encoding="utf-8")
    (out / SUMMARY_PAGE).write_text(summary_page(found), encoding="utf-8")
    return found


def summary_page(found: Sequence[SceneRow]) -> str:
    """HTML of the table of numbers."""
    return render_template(
        "kitchen_summary.html",
        title="Kitchens in numbers",
        sentence=sentence(found),
        head=("scene", "verdict", *(heading for heading, _, _ in COLUMNS)),
        rows=[
            {
                "name": row.id,
                "is_checked": row.passed is not None,
                "kind": VERDICT_STYLES[row.passed],
                "verdict": row.verdict,
                "numbers": cells(row),
            }
            for row in found
        ],
    )


@dataclass(frozen=True)
class SceneCard:
    """A scene as the page tells of it.

    Attributes:
        row: verdict and numbers. fixtures, joints: how many.
        png: overview, or empty.
    """

    row: SceneRow
    fixtures: int
    joints: int
    png: bytes


def _card(folder: Path, row: SceneRow) -> SceneCard:
    facts = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    picture = folder / "overview.png"
    return SceneCard(
        row,
        len(facts["fixtures"]),
        sum(len(f["joints"]) for f in facts["fixtures"]),
        picture.read_bytes() if picture.is_file() else b"",
    )


def write(out: Path, heading: str = "Kitchens") -> tuple[Path, Path]:
    """Write page, contact sheet and table of all scenes in a folder; returns the paths of page and sheet."""
    found = [_card(out / row.id, row) for row in write_summary(out)]
    shots = [
        SheetCell(e.row.id, f"{e.fixtures} fixtures, {e.joints} joints, {e.row.verdict}", _squared(e.png))
        for e in found
    ]
    picture, page = out / SHEET, out / PAGE
    picture.write_bytes(contact_sheet(shots, f"{heading}: {len(found)}", SHEET_COLUMNS, CELL_PX))
    page.write_text(index_page(found, heading), encoding="utf-8")
    return page, picture


def _squared(png: bytes) -> bytes:
    """The picture with paper above and below, as cells of sheets are square."""
    if not png:
        return png
    with Image.open(io.BytesIO(png)) as opened:
        picture = opened.convert("RGB")
    side = max(picture.size)
    square = Image.new("RGB", (side, side), PAPER)
    square.paste(picture, ((side - picture.width) // 2, (side - picture.height) // 2))
    out = io.BytesIO()
    square.save(out, format="PNG", compress_level=1)
    return out.getvalue()


def index_page(found: list[SceneCard], heading: str) -> str:
    """HTML of the page with a picture of each scene."""
    return render_template(
        "kitchens.html",
        title=heading,
        sentence=sentence([card.row for card in found]),
        numbers=SUMMARY_PAGE,
        scenes=[
            {
                "name": card.row.id,
                "kind": VERDICT_STYLES[card.row.passed],
                "verdict": card.row.verdict,
                "is_checked": card.row.passed is not None,
                "fixtures": card.fixtures,
                "joints": card.joints,
            }
            for card in found
        ],
    )
