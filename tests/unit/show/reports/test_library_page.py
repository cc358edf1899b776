"""The report on a library: its page, numbers, earlier runs, conditions that fail a build, and files for CI."""

from __future__ import annotations

import dataclasses
import json
import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import lxml.html
import pytest
from lxml import etree
from PIL import Image

from casa_assets import registry
from casa_assets.errors import OutputError
from casa_assets.library import entry_files
from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import Producer, Refusal, Summary, write_refusal
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Guess
from casa_assets.model.issue import REVIEW_CODE, CheckResult, Decision, Issue, Report, Severity, Status, tally
from casa_assets.model.source import Source, SourceKind
from casa_assets.show.page.page_template import DEFAULT_ADVICE, Words, relative_link
from casa_assets.show.reports import findings as told_of
from casa_assets.show.reports import library_page
from casa_assets.show.reports.findings import Change, Findings, Standing, compare, read_run, standing_of
from casa_assets.show.reports.gate import COUNTS, BadCondition, judge, junit, parse, sarif
from casa_assets.show.reports.library_page import render_library_section, rows_of, write
from tests.support.library.built_libraries import keep
from tests.unit.library.test_alike import FIRST, OTHER

HOSTILE = "</script><script>alert('x')</script><img src=x onerror=alert(1)>\"'&<!--]]>\u2028{{}}$title ${x}"
BLANK = {field.name: "" for field in dataclasses.fields(Entry)} | {"checks": tally([]), "summary": None}
BLANK |= {"warnings": (), "results": (), "guesses": ()}


def entry(name: str = "mug_0000000001", mass: float = 0.25, warned: bool = False, word: str = "A mug") -> Entry:
    issue = Issue(code="GEO004", severity=Severity.WARNING, pointer=word, message=word)
    results = (
        CheckResult(code="AST001", status=Status.PASSED, number=0.123456789, limit=1.0, unit="m"),
        CheckResult(code="AST002", status=Status.FAILED, number=None),
        CheckResult(code="AST003", status=Status.FAILED, severity=Severity.WARNING),
        CheckResult(code="KIN001", status=Status.NOT_APPLICABLE, reason=word),
        CheckResult(code="USD003", status=Status.NOT_RUN, reason=word),
    )
    described: dict[str, Any] = {
        "id": name,
        "category": "mug",
        "accepted": True,
        "path": f"mug/{name}",
        "summary": Summary(extents=(0.08, 0.1, 0.0955), mass=mass, colliders=12, hull_vertices=40, faces=1234),
        "source": "folder",
        **dict.fromkeys(("source_path", "licence", "author", "title", "uri"), word),
        "warnings": (issue,) if warned else (),
        "results": results,
        "checks": tally(results),
        "guesses": (Guess(subject="scale", value=word, confidence=0.8, reason=word),),
    }
    return Entry(**{**BLANK, **described})


def reject(path: str = "a.glb", code: str = "SRC003", word: str = "cannot be read") -> Entry:
    failed = CheckResult(code="GEO001", status=Status.FAILED, number=3.0, limit=1.0, unit="m")
    described = {"id": f"mug_{path}", "category": "mug", "accepted": False, "code": code, "source_path": path}
    return Entry(**{**BLANK, **described, "message": word, "path": f"rejected/{path}", "results": (failed,)})


WORDS = Words(registry.load().rejections, {"AST001": "Size: is bounded"})


def findings(entries: Sequence[Entry], before: Sequence[Entry] | None = None, *conditions: str) -> Findings:
    fits = told_of.fits(entries, registry.load().categories)
    compared = None
    if before is not None:
        compared = told_of.Compared("old", tuple(compare(map(standing_of, before), map(standing_of, entries))))
    totals = told_of.Totals(entries)
    counts = told_of.counts(totals, fits, compared)
    outcomes = judge([parse(text, {"SRC003"}) for text in conditions], counts, totals.codes)
    return Findings("Run", ".", tuple(entries), fits, None, compared, outcomes)


def render(found: Findings, words: Words = WORDS, links: dict[str, str] | None = None) -> str:
    return library_page.render(found, words, rows_of(found.entries, found, words), links)


page = lxml.html.document_fromstring


def data(text: str) -> Any:
    """What the page's script reads."""
    return json.loads(page(text).get_element_by_id("data").text_content())


def rows_written(root: Path) -> Any:
    """Rows on the page of a library."""
    return data(write(root, root / "report.html").page.read_text(encoding="utf-8"))["rows"]


def tile(text: str, name: str) -> str:
    """The large number in a tile of the summary."""
    return str(page(text).xpath(f"//div[@class='tile {name}']//strong")[0].text_content())


def test_the_numbers_at_the_top() -> None:
    rejects = [reject(), reject("b.glb"), reject("c.glb", "SRC001")]
    text = render(findings([entry(), entry("mug_0000000002", 1.9, warned=True), *rejects]))
    expected = {"accepted": "2", "rejected": "3", "advised": "1", "odd": "1", "checks": "2", "categories": "1"}
    assert {name: tile(text, name) for name in expected} == expected
    empty = render(findings([]))
    assert tile(empty, "zero") == "0"
    assert data(empty)["rows"] == []


def test_a_mark_that_nearly_all_assets_have_is_no_mark() -> None:
    def with_advice(number: int, *codes: str) -> Entry:
        issues = tuple(Issue(code=code, severity=Severity.WARNING, message="why") for code in codes)
        return dataclasses.replace(entry(f"mug_{number:010}"), warnings=issues)

    rescaled, common, rare = "MSH014", "FLT011", "FLT018"
    many = [with_advice(i, common) for i in range(2, 9)]
    text = render(findings([with_advice(0, common, rare), with_advice(1, rescaled), *many]))
    assert WORDS.needs_nothing(rescaled)
    assert data(text)["quiet"] == [common, rescaled]
    assert tile(text, "advised") == "1"
    assert "8 others have routine notes" in text
    # Of a few assets all may have the same that has to be looked at.
    assert data(render(findings([with_advice(i, common) for i in range(5)])))["quiet"] == []


def test_hostile_text_stays_text_and_nothing_is_fetched() -> None:
    bad = [entry(word=HOSTILE, warned=True), reject(HOSTILE, word=HOSTILE)]
    text = render(findings(bad, []), Words({}, {"AST001": HOSTILE}))
    tree = page(text)
    plain = page(render(findings([entry(warned=True), reject()], []), Words({}, {"AST001": "plain"})))
    assert [e.tag for e in tree.iter()] == [e.tag for e in plain.iter()]
    first, second = data(text)["rows"]
    assert (first["title"], second["more"]["reason"]) == (HOSTILE, HOSTILE)
    assert "<script>alert" not in text
    assert relative_link("javascript:alert(1)") == "./javascript%3Aalert%281%29"
    assert relative_link("//evil.example/a b#?%") == "./evil.example/a%20b%23%3F%25"
    text = render(findings([entry(), reject()]))
    tree = page(text)
    assert not re.findall(r"(?:https?:)?//[a-z0-9.-]+\.[a-z]{2,}", text.replace("http://www.w3.org/2000/svg", ""))
    assert not tree.xpath("//link | //iframe | //script[@src] | //img[@src]")
    assert not any(word in text for word in ("@import", "url("))
    policy = tree.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0]
    assert ("default-src 'none'" in policy, "http" in policy) == (True, False)
    scripts = " ".join(script.text_content() for script in tree.xpath("//script[not(@type)]"))
    for word in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "fetch(", "XMLHttp"):
        assert word not in scripts


def test_what_changed_is_shown_with_links_to_both_runs() -> None:
    worse, new = entry("mug_0000000001", warned=True), entry("mug_0000000002")
    gone = entry("mug_0000000003")
    found = findings([worse, new], [entry("mug_0000000001"), gone], "worse", "rejected>2")
    tree = page(render(found, links={"mug_0000000001": "../old/report.html#mug_0000000001"}))
    table = tree.get_element_by_id("panel-changes")
    text = " ".join(table.text_content().split())
    assert "1 worse, 0 better, 1 appeared, 1 gone" in text
    assert "accepted, advice GEO004" in text
    links = table.xpath(".//a/@href")
    assert "#mug_0000000001" in links
    assert "./../old/report.html#mug_0000000001" in links
    assert "#mug_0000000003" not in links
    assert [li.get("class") for li in tree.xpath("//ul[@class='conditions']/li")] == ["bad-text", "good"]


def test_numbers_tell_categories_reasons_and_what_is_unusual() -> None:
    found = findings([entry(), entry("mug_0000000002", 30.0), reject()])
    told = told_of.content(found, WORDS)
    assert told["categories"] == [{"name": "mug", "accepted": 2, "review": 0, "rejected": 1}]
    assert [(row["verdict"], row["reason"], row["count"]) for row in told["reasons"]] == [("rejected", "SRC003", 1)]
    assert told["reasons"][0]["meaning"]
    mass = next(row for row in told["priors"] if row["quantity"] == "mass")
    assert [outlier["id"] for outlier in mass["outliers"]] == ["mug_0000000002"]
    assert mass["outliers"][0]["over"]
    assert mass["outliers"][0]["factor"] == pytest.approx(30.0 / mass["usual"][2])
    rows = page(render(found)).xpath("//section[h2[starts-with(., 'Sizes and masses')]]//tr[td]")
    cells = [[" ".join(cell.text_content().split()) for cell in row] for row in rows]
    low, _, high = mass["usual"]
    assert cells[0][:5] == ["mug", "mass", f"{low:g} to {high:g} kg", "2", "1"]
    assert cells[0][5].startswith("mug_0000000002 ")
    assert cells[0][5].endswith(" times over")


def test_of_many_inputs_the_page_has_what_did_not_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = keep(tmp_path / "library", [FIRST, OTHER])
    whole = rows_written(root)
    assert [row.pop("thumb")[:15] for row in whole] == ["data:image/webp"] * 2
    monkeypatch.setattr(library_page, "MAX_WHOLE", 1)
    assert rows_written(root) == whole
    every, shown = (
        rows_of([entry()], findings([entry()]), WORDS, None, is_brief)[0]["more"]["results"]
        for is_brief in (False, True)
    )
    assert shown == [result for result in every if result[0] in ("AST002", "AST003", "USD003")]


def test_a_page_of_2500_inputs_stays_below_ten_megabytes() -> None:
    passed = CheckResult(code="AST001", status=Status.PASSED, number=0.123456789, limit=1.0, unit="m")
    one = dataclasses.replace(entry(warned=True), uri=f"https://example.org/{'a' * 80}")
    one = dataclasses.replace(one, results=(*one.results, *(passed,) * 70), guesses=one.guesses * 6)
    found = findings([dataclasses.replace(one, id=f"mug_{i:010}", path=f"mug/mug_{i:010}") for i in range(2500)])
    text = library_page.render(found, WORDS, rows_of(found.entries, found, WORDS, None, is_brief=True))
    assert 1_000_000 < len(text.encode()) < 10_000_000


def test_words_on_the_library_as_a_whole_is_text() -> None:
    issues = (Issue(code="LIB001", severity=Severity.WARNING, pointer=HOSTILE, message=HOSTILE),)
    results = (
        CheckResult(code="LIB001", status=Status.FAILED, number=0.004, limit=0.025),
        CheckResult(code="LIB002", status=Status.PASSED),
        CheckResult(code="LIB003", status=Status.NOT_RUN, reason="no weights"),
    )
    report = Report(subject="library", results=results, issues=issues)
    told = render_library_section(report, {"LIB001": HOSTILE}, HOSTILE)
    tree = lxml.html.fromstring(f"<main>{told}</main>")
    (found,) = tree.xpath("//section[@class='card']")
    assert [e.text for e in found.xpath(".//em")] == ["1 found", "passed", "not run: no weights"]
    assert found.xpath(".//script | .//img") == []
    assert render_library_section(None, {}) == render_library_section(Report(subject="library"), {}) == ""


CASES = [
    ("FLT005", "links/object/visuals: 2 large parts stand apart; give each object a file of its own, or join them"),
    ("FLT010", "materials: is black"),
    ("MSH002", "all faces lie in one plane; a thing that is handled needs a thickness"),
]


def refused(root: Path, code: str, message: str) -> None:
    folder = Library(root).refusal_folder(f"mug_{code.lower()}0000")
    folder.mkdir(parents=True)
    source = Source(kind=SourceKind.FOLDER, path=f"{code}.glb")
    words = {"id": folder.name, "code": code, "message": message, "category": "mug", "source": source}
    keys = {"producer": Producer.INGEST, "cache_key": "0" * 64, "sha256": "0" * 64}
    write_refusal(folder, Refusal.model_validate({**words, **keys}))
    Image.new("RGB", (32, 32), (200, 30, 30)).save(folder / entry_files.PICTURE)


def test_every_reject_has_a_picture_a_reason_and_what_to_do(tmp_path: Path) -> None:
    for code, message in CASES:
        refused(tmp_path, code, message)
    rejects = {row["codes"][0]: {**row["more"], "thumb": row["thumb"]} for row in rows_written(tmp_path)}
    assert rejects.keys() == {code for code, _ in CASES}
    for row in rejects.values():
        assert row["thumb"].startswith("data:image/webp")
        assert row["reason"]
        assert row["fix"].endswith(".")
    # What a check says is parted into fault and remedy; a stage has its own words.
    assert rejects["FLT005"]["reason"] == "links/object/visuals: 2 large parts stand apart."
    assert rejects["FLT005"]["fix"] == "Give each object a file of its own, or join them."
    assert rejects["FLT010"]["fix"] == DEFAULT_ADVICE
    assert rejects["MSH002"]["reason"] == CASES[2][1]
    assert rejects["MSH002"]["fix"].startswith("Give the model a thickness")


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


def test_a_report_says_what_changed_since_its_own_earlier_version(tmp_path: Path) -> None:
    root = keep(tmp_path / "library", [FIRST, OTHER])
    first = write(root, root / "report.html")
    of_library, of_report = read_run(root), read_run(first.json)
    assert of_library.standings == of_report.standings
    assert of_library.page == of_report.page == first.page
    assert of_library.root.resolve() == of_report.root.resolve()
    shutil.rmtree(Library(root).folder("mug", OTHER.id))
    again = write(root, root / "report.html", first.json, [parse("gone", ()), parse("worse", ())])
    assert [outcome.holds for outcome in again.outcomes] == [True, False]
    found = json.loads(again.json.read_text(encoding="utf-8"))
    assert found["baseline"]["counts"] == {"better": 0, "worse": 0, "appeared": 0, "gone": 1}
    assert found["baseline"]["differences"][0]["id"] == OTHER.id
    assert found["conditions"][0] == {"condition": "gone", "measured": 1, "holds": True}
    assert OTHER.id in again.page.read_text(encoding="utf-8")


def test_what_is_no_report_is_refused(tmp_path: Path) -> None:
    path, no_report = tmp_path / "report.json", ("{", "[]", '{"entries": [{"id": 1}]}', '{"library": "x"}')
    version = ('{"schema_version": 2}', "schema version 2, and this program reads 1")
    for content, message in [*((text, "is no report of a library") for text in no_report), version]:
        path.write_text(content, encoding="utf-8")
        with pytest.raises(OutputError, match=message):
            read_run(path)
    for place in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(OutputError, match="is no earlier run"):
            read_run(place)


CODES = {"FLT005", "MSH014"}
NUMBERS = {**dict.fromkeys(COUNTS, 0), "entries": 40, "accepted": 36, "rejected": 3, "advice": 10, "worse": 2}


def test_a_condition_means_what_it_says_and_what_is_none_is_refused() -> None:
    for text, measured, holds, told in [
        ("rejected", 3, True, "FAIL rejected: 3 of 40, allowed 0"),
        ("rejected>3", 3, False, "PASS rejected: 3 of 40, allowed 3"),
        ("rejected >= 3", 3, True, "FAIL rejected: 3 of 40, allowed less than 3"),
        ("rejected-rate>5%", 0.075, True, "FAIL rejected-rate: 7.5 % of 40, allowed 5 %"),
        ("rejected-rate>0.08", 0.075, False, "PASS rejected-rate: 7.5 % of 40, allowed 8 %"),
        ("accepted<100", 36, True, "FAIL accepted: 36 of 40, allowed at least 100"),
        ("accepted<=35", 36, False, "PASS accepted: 36 of 40, allowed more than 35"),
        ("entries<50", 40, True, "FAIL entries: 40, allowed at least 50"),
        ("worse", 2, True, "FAIL worse: 2 of 40, allowed 0"),
        ("FLT005", 4, True, "FAIL FLT005: 4 of 40, allowed 0"),
        ("MSH014", 0, False, "PASS MSH014: 0 of 40, allowed 0"),
        ("FLT005>4", 4, False, "PASS FLT005: 4 of 40, allowed 4"),
    ]:
        (outcome,) = judge([parse(text, CODES)], NUMBERS, {"FLT005": 4})
        assert (outcome.measured, outcome.holds) == (pytest.approx(measured), holds), text
        assert f"{outcome.mark} {outcome}" == told
    for text, why in [
        ("rejected=5", "is no condition"),
        ("", "is no condition"),
        ("rejectd-rate>5%", "did you mean rejected-rate"),
        ("entries-rate>5%", "nothing is called 'entries-rate'"),
        ("FLT999", "nothing is called 'FLT999'"),
        ("rejected>5%", "% belongs to a rate"),
        ("rejected-rate>5", "a rate is 0 to 1"),
    ]:
        with pytest.raises(BadCondition, match=f"{why}.*mass-outliers"):
            parse(text, CODES)


UNDECIDED = dataclasses.replace(
    entry("mug_0000000003"),
    warnings=(Issue(code=REVIEW_CODE, severity=Severity.WARNING, pointer="category", message="which kind is it"),),
)
ENTRIES = [entry(), entry("mug_0000000002", warned=True), reject("a b.glb")]


def cases(text: str, kind: str) -> dict[str, str]:
    """Name of each test case with such a mark -> its message."""
    found = etree.fromstring(text.encode()).xpath(f"//testcase[{kind}]")
    return {str(case.get("name")): str(case.find(kind).get("message")) for case in found}


def test_rejected_inputs_are_failures_unless_conditions_are_set() -> None:
    text = junit(findings(ENTRIES))
    assert cases(text, "failure") == {"mug_a b.glb": "SRC003: cannot be read"}
    suite = etree.fromstring(text.encode()).find("testsuite[@name='inputs']")
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("3", "1", "0")
    (case,) = suite.xpath("testcase[failure]")
    assert case.get("file") == "a b.glb"
    assert UNDECIDED.to_decide  # else the next line would say nothing
    assert list(cases(junit(findings([UNDECIDED])), "skipped")) == [UNDECIDED.id]
    text = junit(findings(ENTRIES, None, "rejected>0", "rejected-rate>50%"))
    assert list(cases(text, "failure")) == ["rejected>0"]
    assert list(cases(text, "skipped")) == ["mug_a b.glb"]
    assert cases(junit(findings(ENTRIES, None, "rejected>1")), "failure") == {}


def test_results_of_sarif_and_texts_of_strangers() -> None:
    run = json.loads(sarif(findings([*ENTRIES, UNDECIDED], None, "rejected"), WORDS))["runs"][0]
    found = [(one["ruleId"], one["level"]) for one in run["results"]]
    assert {("fail-on", "error"), ("SRC003", "error"), ("GEO004", "warning")} <= set(found)
    assert [level for rule, level in found if rule == REVIEW_CODE] == ["note"]
    assert {rule["id"] for rule in run["tool"]["driver"]["rules"]} == {rule for rule, _ in found}
    (refused,) = (one for one in run["results"] if one["ruleId"] == "SRC003")
    assert refused["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "a%20b.glb"
    assert len({one["partialFingerprints"]["casaAssets/v1"] for one in run["results"]}) == len(found)

    # Texts of strangers are whole files.
    word = HOSTILE + "\x00\x1b[31m\ud800"
    refused = reject(word, word=word)
    assert len(cases(junit(findings([refused])), "failure")) == 1
    assert json.loads(sarif(findings([refused]), WORDS))["runs"][0]["results"][0]["ruleId"] == "SRC003"
