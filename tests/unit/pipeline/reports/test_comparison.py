"""Two runs beside each other: what is better, worse, new and gone, from a library or from its report."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.model.issue import Decision
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports.findings import Change, Standing, compare, link_before, read_run
from casa_assets.pipeline.reports.gate import parse
from casa_assets.pipeline.reports.library_page import write
from tests.built_libraries import keep
from tests.unit.pipeline.test_alike import FIRST, OTHER

A, B, C = "0a0a0a0a0a", "0b0b0b0b0b", "0c0c0c0c0c"


def standing(digits: str, verdict: Decision, *codes: str, category: str = "mug") -> Standing:
    return Standing(f"{category}_{digits}", category, f"{category}/{category}_{digits}", verdict, codes, "x.glb")


def test_how_one_input_does(subtests: pytest.Subtests) -> None:
    for before, now, change in [
        (standing(A, Decision.ACCEPTED), standing(A, Decision.REJECTED, "FLT005"), Change.WORSE),
        (standing(A, Decision.ACCEPTED), standing(A, Decision.REVIEW, "REV001"), Change.WORSE),
        (standing(A, Decision.REJECTED, "FLT005"), standing(A, Decision.REVIEW, "REV001"), Change.BETTER),
        (standing(A, Decision.ACCEPTED), standing(A, Decision.ACCEPTED, "GEO004"), Change.WORSE),
        (standing(A, Decision.ACCEPTED, "GEO004"), standing(A, Decision.ACCEPTED), Change.BETTER),
        (standing(A, Decision.ACCEPTED, "GEO004"), standing(A, Decision.ACCEPTED, "SRC042"), Change.WORSE),
        (standing(A, Decision.REJECTED, "FLT005"), standing(A, Decision.REJECTED, "MSH002"), None),
        (standing(A, Decision.ACCEPTED), standing(A, Decision.ACCEPTED, category="cup"), None),
        (standing(A, Decision.ACCEPTED), None, Change.GONE),
        (None, standing(A, Decision.ACCEPTED), Change.APPEARED),
    ]:
        with subtests.test(before=before, now=now, change=change):
            found = compare([before] if before else [], [now] if now else [])
            assert [one.change for one in found] == ([change] if change else [])


def test_what_is_worse_comes_first() -> None:
    before = [standing(A, Decision.ACCEPTED), standing(B, Decision.REVIEW)]
    now = [standing(A, Decision.REJECTED, "FLT005"), standing(B, Decision.ACCEPTED), standing(C, Decision.ACCEPTED)]
    assert [one.change for one in compare(before, now)] == [Change.WORSE, Change.BETTER, Change.APPEARED]


def test_a_report_of_another_form_is_refused(tmp_path: Path) -> None:
    root = keep(tmp_path / "library", [FIRST])
    path = write(root, root / "report.html").json
    told = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**told, "schema_version": 2}), encoding="utf-8")
    with pytest.raises(OutputError, match="schema version 2, and this program reads 1"):
        read_run(path)


def test_a_library_and_its_report_are_the_same_run(tmp_path: Path) -> None:
    root = keep(tmp_path / "library", [FIRST, OTHER])
    written = write(root, root / "report.html")
    of_library, of_report = read_run(root), read_run(written.json)
    assert of_library.standings == of_report.standings
    assert of_library.page == of_report.page == written.page
    assert of_library.root.resolve() == of_report.root.resolve()


def test_a_report_tells_what_changed_since_its_own_earlier_version(tmp_path: Path) -> None:
    root = keep(tmp_path / "library", [FIRST, OTHER])
    first = write(root, root / "report.html")
    shutil.rmtree(disk.Library(root).folder("mug", OTHER.id))
    again = write(root, root / "report.html", first.json, [parse("gone", ()), parse("worse", ())])
    assert [outcome.holds for outcome in again.outcomes] == [True, False]
    told = json.loads(again.json.read_text(encoding="utf-8"))
    assert told["baseline"]["counts"] == {"better": 0, "worse": 0, "appeared": 0, "gone": 1}
    assert told["baseline"]["differences"][0]["id"] == OTHER.id
    assert told["conditions"][0] == {"condition": "gone", "measured": 1, "holds": True}
    assert OTHER.id in again.page.read_text(encoding="utf-8")


def test_links_lead_to_the_earlier_page_or_to_the_entry(tmp_path: Path) -> None:
    root = keep(tmp_path / "old", [FIRST])
    page = tmp_path / "new" / "report.html"
    (one,) = read_run(root).standings
    assert link_before(read_run(root), one, page) == f"../old/{one.path}/asset.json"
    write(root, root / "report.html")
    assert link_before(read_run(root), one, page) == f"../old/report.html#{FIRST.id}"
    shutil.rmtree(root / one.path)
    (root / "report.html").unlink()
    assert link_before(read_run(root / "report.json"), one, page) == ""


def test_what_is_no_report_is_told(subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory) -> None:
    for content in ["{", "[]", '{"entries": [{"id": 1}]}', '{"library": "x"}']:
        with subtests.test(content=content):
            tmp_path = tmp_path_factory.mktemp("case")
            path = tmp_path / "report.json"
            path.write_text(content, encoding="utf-8")
            with pytest.raises(OutputError, match="is no report of a library"):
                read_run(path)
            with pytest.raises(OutputError, match="is no earlier run"):
                read_run(tmp_path)
            with pytest.raises(OutputError, match="is no earlier run"):
                read_run(tmp_path / "nowhere")
