"""All scenes of a folder on one page, and on one contact sheet."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from casa_assets.preview.sheet import Shot, sheet

PAGE, SHEET = "index.html", "contact_sheet.png"
CELL_PX, COLUMNS = 360, 4
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
class Entry:
    """A scene as the page tells of it.

    Attributes:
        id, plan, style: names. fixtures, joints: how many.
        passed: None where no check has run. errors: codes with how often.
        png: overview, or empty.
    """

    id: str
    plan: str
    style: str
    fixtures: int
    joints: int
    passed: bool | None
    errors: dict[str, int]
    png: bytes

    @property
    def verdict(self) -> str:
        """One word or the codes of what is wrong."""
        if self.passed is None:
            return "not checked"
        return "passed" if self.passed else ", ".join(f"{code} x {n}" for code, n in sorted(self.errors.items()))


def entries(out: Path) -> list[Entry]:
    """Every scene below a folder, by id."""
    return [_entry(path.parent) for path in sorted(out.glob("*/scene.json"))]


def _entry(folder: Path) -> Entry:
    facts = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    report = _report(folder)
    errors: dict[str, int] = {}
    for issue in (report or {}).get("issues", []):
        if issue["severity"] == "error":
            errors[issue["code"]] = errors.get(issue["code"], 0) + 1
    picture = folder / "overview.png"
    return Entry(
        facts["id"],
        facts["plan"],
        facts["style"],
        len(facts["fixtures"]),
        sum(len(f["joints"]) for f in facts["fixtures"]),
        None if report is None else not errors,
        errors,
        picture.read_bytes() if picture.is_file() else b"",
    )


def _report(folder: Path) -> dict[str, Any] | None:
    path = folder / "report.json"
    if not path.is_file():
        return None
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def write(out: Path, heading: str = "Kitchens") -> tuple[Path, Path]:
    """Write the page and the contact sheet of all scenes in a folder; returns their paths."""
    found = entries(out)
    shots = [Shot(e.id, f"{e.fixtures} fixtures, {e.joints} joints, {e.verdict}", e.png) for e in found]
    picture, page = out / SHEET, out / PAGE
    picture.write_bytes(sheet(shots, f"{heading}: {len(found)}", COLUMNS, CELL_PX))
    page.write_text(_page(found, heading), encoding="utf-8")
    return page, picture


def _page(found: list[Entry], heading: str) -> str:
    cells = "\n".join(_cell(e) for e in found)
    passed = sum(bool(e.passed) for e in found)
    checked = sum(e.passed is not None for e in found)
    return (
        f"<!doctype html><html lang='en'><meta charset='utf-8'><title>{html.escape(heading)}</title>"
        f"<style>{STYLE}</style><h1>{html.escape(heading)}</h1>"
        f"<p>{len(found)} scenes, {passed} of {checked} that were checked passed.</p>"
        f"<div class='cells'>{cells}</div></html>\n"
    )


def _cell(entry: Entry) -> str:
    mark = {True: "passed", False: "failed", None: "open"}[entry.passed]
    report = f"<a href='{entry.id}/report.html'>report</a>" if entry.passed is not None else ""
    return (
        f"<figure><a href='{entry.id}/'><img loading='lazy' src='{entry.id}/overview.png' alt='{entry.id}'></a>"
        f"<figcaption><b>{entry.id}</b> <span class='{mark}'>{html.escape(entry.verdict)}</span> {report}<br>"
        f"<small>{entry.fixtures} fixtures, {entry.joints} joints</small></figcaption></figure>"
    )
