"""All scenes of a folder on one page, on one contact sheet and in one table."""

from __future__ import annotations

import html
import io
import json
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from PIL import Image

from casa_assets.pipeline.reports import kitchen_summary
from casa_assets.pipeline.reports.kitchen_summary import SceneRow
from casa_assets.preview.sheet import Shot, sheet

PAGE, SHEET = "index.html", "contact_sheet.png"
CELL_PX, COLUMNS = 360, 4
PAPER = (244, 244, 245)
STYLE = """
:root { color-scheme: light dark; font-family: system-ui, sans-serif; }
body { margin: 2rem auto; max-width: 1500px; padding: 0 1rem; }
.cells { display: grid; grid-template-columns: repeat(auto-fill, minmax(320px, 1fr)); gap: 18px; }
figure { margin: 0; }
figure img { border-radius: 8px; width: 100%; display: block; }
figcaption { padding: 6px 2px 12px; }
.passed { color: #1a7f37; } .failed { color: #cf222e; } .open { color: #9a6700; }
small { color: #888; }
"""


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
        Shot(e.row.id, f"{e.fixtures} fixtures, {e.joints} joints, {e.row.verdict}", _squared(e.png)) for e in found
    ]
    picture, page = out / SHEET, out / PAGE
    picture.write_bytes(sheet(shots, f"{heading}: {len(found)}", COLUMNS, CELL_PX))
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
    cells = "\n".join(_cell(e) for e in found)
    told = html.escape(kitchen_summary.sentence([e.row for e in found]))
    return (
        f"<!doctype html><html lang='en'><meta charset='utf-8'><title>{html.escape(heading)}</title>"
        f"<style>{STYLE}</style><h1>{html.escape(heading)}</h1>"
        f"<p>{len(found)} scenes. {told}. <a href='{kitchen_summary.PAGE}'>All numbers</a></p>"
        f"<div class='cells'>{cells}</div></html>\n"
    )


def _cell(entry: SceneCard) -> str:
    row = entry.row
    mark = {True: "passed", False: "failed", None: "open"}[row.passed]
    name, place = html.escape(row.id), html.escape(f"./{quote(row.id)}")
    report = f"<a href='{place}/report.html'>report</a>" if row.passed is not None else ""
    return (
        f"<figure><a href='{place}/'><img loading='lazy' src='{place}/overview.png' alt='{name}'></a>"
        f"<figcaption><b>{name}</b> <span class='{mark}'>{html.escape(row.verdict)}</span> {report}<br>"
        f"<small>{entry.fixtures} fixtures, {entry.joints} joints</small></figcaption></figure>"
    )
