"""Two runs beside each other: what is better, worse, new and gone, from a library or from its report."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.library import library as disk
from casa_assets.model.issue import Decision
from casa_assets.show.reports.findings import Change, Standing, compare, link_before, read_run
from casa_assets.show.reports.gate import parse
from casa_assets.show.reports.library_page import write
from tests.support.library.built_libraries import keep
from tests.unit.library.test_alike import FIRST, OTHER

A, B, C = "0a0a0a0a0a", "0b0b0b0b0b", "0c0c0c0c0c"


def standing(digits: str, verdict: Decision, *codes: str, category: str = "mug") -> Standing:
    return Standing(f"{category}_{digits}", category, f"{category}/{category}_{digits}", verdict, codes, "x.glb")


def test_how_one_input_does() -> None:
    accepted, advised = standing(A, Decision.ACCEPTED), standing(A, Decision.ACCEPTED, "GEO004")
    review, rejected = standing(A, Decision.REVIEW, "REV001"), standing(A, Decision.REJECTED, "FLT005")
    for before, now, change in [
        (accepted, rejected, Change.WORSE),
        (accepted, review, Change.WORSE),
        (rejected, review, Change.BETTER),
        (accepted, advised, Change.WORSE),
        (advised, accepted, Change.BETTER),
        (advised, standing(A, Decision.ACCEPTED, "SRC042"), Change.WORSE),
        (rejected, standing(A, Decision.REJECTED, "MSH002"), None),
        (accepted, standing(A, Decision.ACCEPTED, category="cup"), None),
        (accepted, None, Change.GONE),
        (None, accepted, Change.APPEARED),
    ]:
        found = compare([before] if before else [], [now] if now else [])
        assert [one.change for one in found] == ([change] if change else []), (before, now)
    before_, now_ = [accepted, standing(B, Decision.REVIEW)], [standing(B, Decision.ACCEPTED), rejected]
    changes = [one.change for one in compare(before_, [*now_, standing(C, Decision.ACCEPTED)])]
    assert changes == [Change.WORSE, Change.BETTER, Change.APPEARED], "what is worse comes first"


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


def test_what_is_no_report_is_told(tmp_path: Path) -> None:
    path = tmp_path / "report.json"
    other = "schema version 2, and this program reads 1"
    for content, message in [
        *((text, "is no report of a library") for text in ("{", "[]", '{"entries": [{"id": 1}]}', '{"library": "x"}')),
        ('{"schema_version": 2}', other),
    ]:
        path.write_text(content, encoding="utf-8")
        with pytest.raises(OutputError, match=message):
            read_run(path)
    for place in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(OutputError, match="is no earlier run"):
            read_run(place)
