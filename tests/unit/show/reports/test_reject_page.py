"""The page of rejected inputs says of each why, in words, and what to do about it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from casa_assets.library import entry_files
from casa_assets.library import library as disk
from casa_assets.library.library import Producer
from casa_assets.model.source import Source, SourceKind
from casa_assets.show.page.page_template import DEFAULT_ADVICE
from casa_assets.show.reports import library_page

CASES = [
    ("FLT005", "links/object/visuals: 2 large parts stand apart; give each object a file of its own, or join them"),
    ("FLT010", "materials: is black"),
    ("MSH002", "all faces lie in one plane; a thing that is handled needs a thickness"),
]


def refused(root: Path, code: str, message: str) -> None:
    folder = disk.Library(root).refusal_folder(f"mug_{code.lower()}0000")
    folder.mkdir(parents=True)
    source = Source(kind=SourceKind.FOLDER, path=f"{code}.glb")
    words = {"id": folder.name, "code": code, "message": message, "category": "mug", "source": source}
    keys = {"producer": Producer.INGEST, "cache_key": "0" * 64, "sha256": "0" * 64}
    disk.write_refusal(folder, disk.Refusal.model_validate({**words, **keys}))
    Image.new("RGB", (32, 32), (200, 30, 30)).save(folder / entry_files.PICTURE)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    root = tmp_path_factory.mktemp("library")
    for code, message in CASES:
        refused(root, code, message)
    text = library_page.write(root, root / "report.html").page.read_text(encoding="utf-8")
    match = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert match is not None
    rows = json.loads(match.group(1))["rows"]
    return {row["codes"][0]: {**row["more"], "thumb": row["thumb"]} for row in rows}


def test_every_reject_has_a_picture_a_reason_and_what_to_do(page: dict[str, dict[str, Any]]) -> None:
    assert page.keys() == {code for code, _ in CASES}
    for row in page.values():
        assert row["thumb"].startswith("data:image/webp")
        assert row["reason"]
        assert row["fix"].endswith(".")
    # What a check says is parted into fault and remedy; a stage has its own words.
    assert page["FLT005"]["reason"] == "links/object/visuals: 2 large parts stand apart."
    assert page["FLT005"]["fix"] == "Give each object a file of its own, or join them."
    assert page["FLT010"]["fix"] == DEFAULT_ADVICE
    assert page["MSH002"]["reason"] == CASES[2][1]
    assert page["MSH002"]["fix"].startswith("Give the model a thickness")
