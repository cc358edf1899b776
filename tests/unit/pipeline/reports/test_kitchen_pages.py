"""Pages about kitchens show the words of strangers and do nothing that they say."""

from __future__ import annotations

from casa_assets.pipeline.reports import kitchen_report, kitchens
from casa_assets.pipeline.reports.kitchens import SceneRow

HOSTILE = "<span class='x' onclick=alert(1)></span><script>alert(1)</script>'\"&"
BAD = ("<script", "<span class='x'", "onclick=alert(1)>")


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
    assert not [words for words in BAD if words in page]
    assert page.count('<span class="failed">') == 2
    assert page.count('<span class="none">does not apply</span>') == 1


def test_no_name_of_a_scene_is_markup() -> None:
    row = SceneRow(HOSTILE, "plan", "style", passed=True)
    page = kitchens.index_page([kitchens.SceneCard(row, 1, 1, b"")], HOSTILE) + kitchens.summary_page([row])
    assert not [words for words in BAD if words in page]
    assert 'href="./%3Cspan' in page
