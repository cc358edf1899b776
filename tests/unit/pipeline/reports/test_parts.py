"""A large library's data lies in script files beside the page, and is the same as inside a small one's page."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from casa_assets.pipeline.reports import parts
from casa_assets.pipeline.reports.library import rows
from casa_assets.pipeline.reports.library.report import write
from tests.built_libraries import keep
from tests.unit.pipeline.test_alike import FIRST, LARGE, OTHER

SCRIPT = re.compile(r"casaPart\(\"(\w+)\",(\d+),(.*)\);\n", re.DOTALL)


def inside(page: Path) -> dict[str, object]:
    text = page.read_text(encoding="utf-8")
    pattern = r'<script type="application/json" id="part-(\w+)">(.*?)</script>'
    return {name: json.loads(content) for name, content in re.findall(pattern, text, re.DOTALL)}


def beside(page: Path) -> dict[str, object]:
    found: dict[str, object] = {}
    for path in sorted(parts.folder_of(page).iterdir()):
        match = SCRIPT.fullmatch(path.read_text(encoding="utf-8"))
        assert match is not None
        assert path.name == f"{match[1]}_{match[2]}.js"
        found[path.stem] = json.loads(match[3])
    return found


def test_a_large_page_has_its_data_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = keep(tmp_path / "library", [FIRST, OTHER, LARGE])
    page = write(root, root / "report.html").page
    whole = inside(page)
    assert set(whole) == {"numbers_0", "rows_0", "details_0", "pictures_0"}
    monkeypatch.setattr(parts, "MAX_INLINE", 2)
    monkeypatch.setattr(rows, "PART_SIZES", {"rows": 2, "details": 1, "pictures": 3})
    write(root, page)
    split = beside(page)
    assert inside(page) == {}
    assert set(split) == {"numbers_0", "rows_0", "rows_1", "details_0", "details_1", "details_2", "pictures_0"}
    assert [*split["rows_0"], *split["rows_1"]] == whole["rows_0"]  # type: ignore[misc]
    assert [one for i in range(3) for one in split[f"details_{i}"]] == whole["details_0"]  # type: ignore[attr-defined]
    before = {path.name: path.read_bytes() for path in parts.folder_of(page).iterdir()}
    write(root, page)
    assert {path.name: path.read_bytes() for path in parts.folder_of(page).iterdir()} == before
    monkeypatch.undo()
    write(root, page)
    assert not parts.folder_of(page).exists()
    assert inside(page) == whole
