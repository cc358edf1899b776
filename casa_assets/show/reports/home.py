"""One page about all contents of an output folder: kitchens, articulated models, assets, rejected inputs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import PICTURE, Producer
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.kitchen.files import EYE_PICTURE
from casa_assets.runs.outcome import writing
from casa_assets.show.page.page_template import Words, all_words, relative_link, render_template
from casa_assets.show.reports import kitchens

NAME = "index.html"
STRIP = "strip.png"  # of what was articulated: closed, coloured, in parts, open
# Things of one kind that are shown; the others are counted, and the page of their folder has them all.
MOST_SHOWN, MOST_REJECTED = 24, 6
LARGE = 2  # kitchens that are shown large, where there are twice as many or more


def write(out: Path) -> Path:
    """Write index.html of a folder of output; returns its path. Raises OutputError."""
    words = all_words()
    folders = sorted(path for path in out.iterdir() if path.is_dir() and not path.name.startswith("."))
    rooms = [(folder, kitchens.read_cards(folder)) for folder in folders if _holds_kitchens(folder)]
    libraries = [Library(folder) for folder in folders if not _holds_kitchens(folder)]
    shelves = [(one.root, EntryTable(one).entries) for one in libraries if any(one.accepted()) or any(one.refused())]
    text = render_template(
        "home/page.html",
        title="What was made",
        kitchens=[_kitchens(shelf, cards) for shelf, cards in rooms],
        articulated=[
            _articulated(shelf, entry)
            for shelf, entries in shelves
            for entry in entries
            if entry.accepted and entry.producer == Producer.ARTICULATE
        ],
        libraries=[
            _library(shelf, entries, words)
            for shelf, entries in shelves
            if any(entry.producer != Producer.ARTICULATE for entry in entries)
        ],
        styles=("home/page.css",),
    )
    target = out / NAME
    with writing(out):
        target.write_text(text, encoding="utf-8")
    return target


def _holds_kitchens(folder: Path) -> bool:
    return any(folder.glob("*/scene.json"))


def _kitchens(shelf: Path, cards: Sequence[kitchens.SceneCard]) -> dict[str, Any]:
    # Those with most to open first, as large pictures.
    drawn = sorted((c for c in cards if c.pictures), key=lambda c: (-c.joints, c.row.id))[:MOST_SHOWN]
    shown = [
        {
            "id": card.row.id,
            "plan": card.row.plan.replace("_", " "),
            "style": card.row.style.replace("_", " "),
            "picture": relative_link(f"{shelf.name}/{card.row.id}/{kitchens.best_picture(card)}"),
            "link": f"{relative_link(f'{shelf.name}/{kitchens.PAGE}')}#{card.row.id}",
            "told": f"{card.fixtures} fixtures, {card.joints} joints",
            "verdict": "" if card.row.passed is None else kitchens.VERDICTS[card.row.passed],
            "is_large": number < LARGE <= len(cards) // 2,
        }
        for number, card in enumerate(drawn)
    ]
    return {
        "page": relative_link(f"{shelf.name}/{kitchens.PAGE}"),
        "folder": shelf.as_posix(),
        "count": len(cards),
        "at_eye": all(kitchens.best_picture(card) == EYE_PICTURE for card in drawn),
        "unchecked": sum(card.row.passed is None for card in cards),
        "shown": shown,
        "first": shown[0]["id"] if shown else "",
        "first_unchecked": next((card.row.id for card in cards if card.row.passed is None), ""),
    }


def _articulated(shelf: Path, entry: Entry) -> dict[str, Any]:
    folder = shelf / entry.path
    joints = json.loads((folder / "asset.json").read_text(encoding="utf-8"))["asset"].get("joints", [])
    picture = STRIP if (folder / STRIP).is_file() else PICTURE
    return {
        "id": entry.id,
        "category": entry.category.replace("_", " "),
        "source": entry.source_path,
        "picture": relative_link(f"{shelf.name}/{entry.path}/{picture}"),
        "is_strip": picture == STRIP,
        "joints": len(joints),
        "turning": sum(joint["kind"] == JointKind.HINGE for joint in joints),
        "files": [
            (label, relative_link(f"{shelf.name}/{entry.path}/{file}"))
            for label, file in (("MJCF", "model.xml"), ("USD", f"usd/{entry.id}.usda"), ("decisions", "decisions.yaml"))
            if (folder / file).is_file()
        ],
    }


def _library(shelf: Path, entries: Sequence[Entry], words: Words) -> dict[str, Any]:
    accepted, rejected = [e for e in entries if e.accepted], [e for e in entries if not e.accepted]
    report = relative_link(f"{shelf.name}/report.html") if (shelf / "report.html").is_file() else ""
    return {
        "name": shelf.name,
        "page": report,
        "accepted": len(accepted),
        "rejected": len(rejected),
        "shown": [
            {
                "id": entry.id,
                "category": entry.category.replace("_", " "),
                "picture": relative_link(f"{shelf.name}/{entry.path}/{PICTURE}"),
                "link": f"{report}#{entry.id}" if report else relative_link(f"{shelf.name}/{entry.path}"),
                "told": _size_and_mass(entry),
            }
            for entry in accepted[:MOST_SHOWN]
        ],
        "refused": [_refused(shelf, entry, words) for entry in rejected[:MOST_REJECTED]],
    }


def _refused(shelf: Path, entry: Entry, words: Words) -> dict[str, str]:
    reason, fix = words.reason_and_fix(entry)
    has_picture = (shelf / entry.path / PICTURE).is_file()
    picture = relative_link(f"{shelf.name}/{entry.path}/{PICTURE}") if has_picture else ""
    return {"path": entry.source_path, "code": entry.code, "reason": reason, "fix": fix, "picture": picture}


def _size_and_mass(entry: Entry) -> str:
    if entry.summary is None:
        return ""
    size, mass = " x ".join(f"{100 * side:.1f}" for side in entry.summary.extents), entry.summary.mass
    return f"{size} cm, {1000 * mass:.0f} g" if mass < 1 else f"{size} cm, {mass:.3g} kg"
