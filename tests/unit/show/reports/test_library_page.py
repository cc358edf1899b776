"""The page: well formed, its numbers right, no text from an input becomes markup, nothing is fetched."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import lxml.html
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.library import entry_files
from casa_assets.library import library as disk
from casa_assets.library.entry import Entry
from casa_assets.library.library import Producer, Summary
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.issue import CheckResult, Issue, Report, Severity, Status, tally
from casa_assets.model.source import Source, SourceKind
from casa_assets.show.page.page_template import DEFAULT_ADVICE, Words, relative_link
from casa_assets.show.reports import findings as told_of
from casa_assets.show.reports import library_page
from casa_assets.show.reports.findings import Findings, compare, standing_of
from casa_assets.show.reports.gate import judge, parse
from casa_assets.show.reports.library_page import render_library_section, rows_of
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


def tile(text: str, name: str) -> str:
    """The large number in a tile of the summary."""
    return str(page(text).xpath(f"//div[@class='tile {name}']//strong")[0].text_content())


def test_the_numbers_at_the_top() -> None:
    refused = [reject(), reject("b.glb"), reject("c.glb", "SRC001")]
    text = render(findings([entry(), entry("mug_0000000002", 1.9, warned=True), *refused]))
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
    assert "@import" not in text
    assert "url(" not in text
    policy = tree.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0]
    assert "default-src 'none'" in policy
    assert "http" not in policy
    for script in tree.xpath("//script[not(@type)]"):
        for word in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "fetch(", "XMLHttp"):
            assert word not in script.text_content()


def test_what_changed_is_told_with_links_to_both_runs() -> None:
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
    whole = data(library_page.write(root, root / "report.html").page.read_text(encoding="utf-8"))["rows"]
    assert [row.pop("thumb")[:15] for row in whole] == ["data:image/webp"] * 2
    monkeypatch.setattr(library_page, "MAX_WHOLE", 1)
    assert data(library_page.write(root, root / "report.html").page.read_text(encoding="utf-8"))["rows"] == whole
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


def test_what_is_said_of_the_library_as_a_whole_is_text() -> None:
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
    folder = disk.Library(root).refusal_folder(f"mug_{code.lower()}0000")
    folder.mkdir(parents=True)
    source = Source(kind=SourceKind.FOLDER, path=f"{code}.glb")
    words = {"id": folder.name, "code": code, "message": message, "category": "mug", "source": source}
    keys = {"producer": Producer.INGEST, "cache_key": "0" * 64, "sha256": "0" * 64}
    disk.write_refusal(folder, disk.Refusal.model_validate({**words, **keys}))
    Image.new("RGB", (32, 32), (200, 30, 30)).save(folder / entry_files.PICTURE)


def test_every_reject_has_a_picture_a_reason_and_what_to_do(tmp_path: Path) -> None:
    for code, message in CASES:
        refused(tmp_path, code, message)
    rows = data(library_page.write(tmp_path, tmp_path / "report.html").page.read_text(encoding="utf-8"))["rows"]
    rejects = {row["codes"][0]: {**row["more"], "thumb": row["thumb"]} for row in rows}
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
