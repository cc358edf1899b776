"""Pages about kitchens show the words of strangers and do nothing that they say."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from lxml import html

from casa_assets.layouts.run.diversity import Choices, Traits, diversity_of, write_diversity
from casa_assets.show.page import kitchen_report
from casa_assets.show.reports import kitchens
from casa_assets.show.reports.kitchens import SceneRow

HOSTILE = "<span class='x' onclick=alert(1)></span><script>alert(1)</script>'\"&"
BAD = ("<script>alert", "<span class='x'", "onclick=alert(1)>")


def test_no_cell_of_a_report_is_markup() -> None:
    facts = {"id": HOSTILE, "fixtures": [{"joints": []}], "generator": HOSTILE}
    issue = {"code": HOSTILE, "severity": "error", "pointer": HOSTILE, "message": HOSTILE}
    rule = {"rule": HOSTILE, "title": HOSTILE, "number": 1.0, "limit": 2.0, "unit": HOSTILE}
    rule |= {"most": True, "waived": False}
    rules = [{**rule, "passed": passed} for passed in (True, False, None)]
    report = {
        "passed": False,
        "issues": [issue],
        "results": [],
        "holds": {HOSTILE: 1.0},
        "tasks": [{"task": HOSTILE, "fixtures": [HOSTILE], "rate": None}],
        "grade": {"score": 1.0, "access_score": 1.0, "design": rules, "access": []},
    }
    page = kitchen_report.page(facts, report, {})
    assert page.count('<span class="failed">') == 2
    assert page.count('<span class="none">1 not applicable</span>') == 1
    row = SceneRow(HOSTILE, "plan", "style", passed=True)
    cards = [kitchens.SceneCard(row, 1, 1, families=(HOSTILE,), tasks=(HOSTILE,), pictures=(HOSTILE,))]
    index = kitchens.index_page(cards, HOSTILE)
    assert not [words for words in BAD if words in page + index]
    assert rows_of(index)[0]["folder"].startswith("./%3Cspan")


def kitchen_page(explained: Mapping[str, str]) -> str:
    """Page of a kitchen of which one check failed, one gave advice, four passed and one does not apply."""
    results = [
        {"code": "SCN003", "status": "passed", "number": 2.76863e-05, "limit": 0.001, "unit": "m"},
        {"code": "SCN006", "status": "passed", "number": 0.952044, "limit": 0.95},
        {"code": "SCN014", "status": "passed", "number": 12901.0, "limit": 30000.0},
        {"code": "SCN015", "status": "passed", "number": 19.9035, "limit": 256.0, "unit": "MB"},
        {"code": "NKB005", "status": "not_applicable", "reason": "it is not compact"},
        {"code": "SCN026", "status": "failed", "severity": "warning", "number": 6000.0, "limit": 5000.0, "unit": "ms"},
        {"code": "NKB004", "status": "failed", "number": 0.98765, "limit": 1.067, "unit": "m"},
    ]
    rule = {"rule": "N3b_long", "title": "longest leg", "number": 3.04321, "limit": 2.743, "unit": "m", "most": True}
    rules = [{**rule, "passed": passed, "waived": False} for passed in (True, False, None)]
    tasks = [{"task": name, "rate": rate} for name, rate in (("pnp_cab_to_counter", 0.65), ("open_drawer", 0.5))]
    report = {
        "passed": False,
        "issues": [{"code": "NKB004", "severity": "error", "pointer": "main_upper_doors_2", "message": "is narrow"}],
        "results": results,
        "tasks": tasks,
        "holds": {"bodies": 140, "texture_mb": 19.9035},
        "robots": {"PandaOmron": {"joints": 57, "reached": 50, "followed": 49, "margin": 0.25, "without_parking": 2}},
        "grade": {"score": 1.0, "access_score": 1.0, "design": rules, "access": []},
    }
    facts = {"id": "galley__rustic", "fixtures": [], "generator": "casa-assets"}
    return kitchen_report.page(facts, report, explained)


def test_what_failed_comes_first_and_numbers_are_for_people() -> None:
    tree = html.document_fromstring(kitchen_page({"NKB004": "Work aisle: Fronts are apart."}))
    groups = [(group.xpath("string(summary)"), group.get("open") is not None) for group in tree.xpath("//details")]
    assert groups == [
        *[("1 failed", True), ("1 advice", True), ("4 passed", False), ("1 not applicable", False)],
        ("2 supported", False),
        *[("1 not followed", True), ("1 followed", False), ("1 not applicable", False)],
    ]
    cells = [[" ".join(cell.text_content().split()) for cell in row] for row in tree.xpath("//details//tr[td]")]
    assert cells[:6] == [
        ["Work aisle NKB004Fronts are apart.", "0.988 m", "1.07 m"],
        ["SCN026", "6,000 ms", "5,000 ms"],
        ["SCN003", "0.0277 mm", "1 mm"],
        ["SCN006", "95.2 %", "95 %"],
        ["SCN014", "12,901", "30,000"],
        ["SCN015", "19.9 MB", "256 MB"],
    ]
    assert [cell[0] for cell in cells[7:10]] == [
        "Open drawer open_drawer",
        "Pick and place: cabinet to counter pnp_cab_to_counter",
        "Longest leg N3b_long",
    ]
    assert cells[9][1:] == ["3.04 m", "at most 2.74 m"]


def rows_of(page: str) -> Any:
    """The rows that a page lists."""
    return json.loads(html.document_fromstring(page).get_element_by_id("data").text_content())["rows"]


def scene(out: Path, plan: str, style: str, **changed: Any) -> Path:
    """A scene.json with what the index reads."""
    folder = out / f"{plan}__{style}"
    folder.mkdir(parents=True)
    fixture = {"layer": "things", "family": "hob", "joints": {"knob": {}}}
    facts = {"id": folder.name, "plan": plan, "style": style, "fixtures": [fixture]}
    facts |= {"tasks": {"open_drawer": {"afforded": True}, "boil": {"afforded": False}}, "robocasa_v1": {}}
    facts |= {"surfaces": {"floor": "oak"}, "room": {"bounds": [[0, -3, 0], [4, 0, 2.5]]}, **changed}
    (folder / "scene.json").write_text(json.dumps(facts), encoding="utf-8")
    return folder


def test_scenes_that_have_not_changed_are_not_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = scene(tmp_path, "galley", "rustic"), scene(tmp_path, "galley", "coastal")
    monkeypatch.setattr(kitchens, "key_of", lambda _: "the same code")
    before = kitchens.read_cards(tmp_path)
    counted = Mock(side_effect=kitchens._card)
    monkeypatch.setattr(kitchens, "_card", counted)
    assert kitchens.read_cards(tmp_path) == before
    counted.assert_not_called()
    (first / "overview.png").write_bytes(b"png")
    shutil.rmtree(second)
    (again,) = kitchens.read_cards(tmp_path)
    assert again.pictures == ("overview.png",)
    counted.assert_called_once_with(first)


def test_diversity_is_shown_where_it_was_measured(tmp_path: Path) -> None:
    scene(tmp_path, "galley", "rustic")
    page, _ = kitchens.write(tmp_path)
    assert "How diverse" not in page.read_text(encoding="utf-8")
    surfaces = {"wall": "a", "floor": "b", "counter": "c", "cabinet": "d"}
    one = Traits("one", "galley", "rustic", {}, 12.0, surfaces, "slab, bar", {"hob": "hob/gas"})
    possible = Choices(10, 12, 9, dict.fromkeys(surfaces, 100), {"hob": 8})
    drawn = diversity_of([one, replace(one, id="two", plan="u_small")], possible)
    write_diversity(tmp_path, drawn, diversity_of([one], possible))
    page, _ = kitchens.write(tmp_path)
    text = page.read_text(encoding="utf-8")
    assert "How diverse the 2 kitchens drawn at random are" in text
    assert "<td>plans</td><td>1.00</td><td></td>" in text
    assert 'href="contact_sheet.png"' in text


def test_thousands_of_kitchens_are_on_one_page(monkeypatch: pytest.MonkeyPatch) -> None:
    cards = [kitchens.SceneCard(SceneRow(f"plan_{i % 10}__{i}", "p", "s"), 1, 1) for i in range(2500)]
    text = kitchens.index_page(cards, "Kitchens")
    assert len(rows_of(text)) == 2500
    assert "The list has" not in text
    assert len(text) < 1_000_000
    assert len(kitchens.on_sheet(cards)) == kitchens.SHOWN_OF_MORE
    # Of still more kitchens the first ones are listed.
    cards = [kitchens.SceneCard(SceneRow(f"plan_{i}", "p", "s"), 1, 1) for i in range(5)]
    monkeypatch.setattr(kitchens, "MAX_ROWS", 3)
    text = kitchens.index_page(cards, "Kitchens")
    assert [row["id"] for row in rows_of(text)] == ["plan_0", "plan_1", "plan_2"]
    assert "The list has the first 3 of 5 kitchens" in text
    assert 'href="summary.json"' in text
