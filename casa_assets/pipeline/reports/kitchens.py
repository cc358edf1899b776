"""All scenes of a folder on one page, on one contact sheet and in one table."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from casa_assets.pipeline.reports import kitchen_summary
from casa_assets.pipeline.reports.kitchen_summary import VERDICT_STYLES, SceneRow
from casa_assets.pipeline.reports.page_template import render_template
from casa_assets.preview.sheet import SheetCell, contact_sheet

PAGE, SHEET = "index.html", "contact_sheet.png"
CELL_PX, COLUMNS = 360, 4
PAPER = (244, 244, 245)


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


def entries(out: Path, rows: list[SceneRow]) -> list[SceneCard]:
    """Scenes below a folder."""
    return [_entry(out / row.id, row) for row in rows]


def _entry(folder: Path, row: SceneRow) -> SceneCard:
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
    found = entries(out, kitchen_summary.write(out))
    shots = [
        SheetCell(e.row.id, f"{e.fixtures} fixtures, {e.joints} joints, {e.row.verdict}", _squared(e.png))
        for e in found
    ]
    picture, page = out / SHEET, out / PAGE
    picture.write_bytes(contact_sheet(shots, f"{heading}: {len(found)}", COLUMNS, CELL_PX))
    page.write_text(_page(found, heading), encoding="utf-8")
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


def _page(found: list[SceneCard], heading: str) -> str:
    return render_template(
        "kitchens.html",
        title=heading,
        sentence=kitchen_summary.sentence([card.row for card in found]),
        numbers=kitchen_summary.PAGE,
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
