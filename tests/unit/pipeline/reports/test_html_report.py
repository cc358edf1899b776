"""The page: well formed, its numbers right, no text from an input becomes markup, nothing is fetched."""

from __future__ import annotations

import dataclasses
import io
import json
import re
from pathlib import Path
from typing import Any

import lxml.html
import pytest
from PIL import Image

from casa_assets.model.asset.provenance import Guess
from casa_assets.model.issue import CheckResult, Issue, Report, Severity, Status
from casa_assets.pipeline.library.entry_files import thumbnail_of
from casa_assets.pipeline.library.library import Summary
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.reports.html_report import AssetRow, RejectedRow, render_library_section, render_page

HOSTILE = "</script><script>alert('x')</script><img src=x onerror=alert(1)>\"'&<!--]]>\u2028{{}}$title ${x}"


def png(size_px: int = 300) -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (size_px, size_px), (180, 30, 30)).save(out, "PNG")
    return out.getvalue()


BLANK = {field.name: "" for field in dataclasses.fields(Entry)}


def entry(name: str = "mug_0000000001", mass: float = 0.25, warned: bool = False, word: str = "A mug") -> AssetRow:
    issue = Issue(code="GEO004", severity=Severity.WARNING, pointer=word, message=word)
    described: dict[str, Any] = {
        "id": name,
        "category": "mug",
        "accepted": True,
        "summary": Summary(extents=(0.08, 0.1, 0.0955), mass=mass, colliders=12, hull_vertices=40, faces=1234),
        "source": "folder",
        **dict.fromkeys(("source_path", "licence", "author", "title", "uri"), word),
        "warnings": (issue,) if warned else (),
        "results": (
            CheckResult(code="AST001", status=Status.PASSED, number=0.123456789, limit=1.0, unit="m"),
            CheckResult(code="AST002", status=Status.FAILED, number=None),
            CheckResult(code="KIN001", status=Status.NOT_APPLICABLE, reason=word),
            CheckResult(code="USD003", status=Status.NOT_RUN, reason=word),
        ),
        "guesses": (Guess(subject="scale", value=word, confidence=0.8, reason=word),),
    }
    return AssetRow(Entry(**{**BLANK, **described}), f"mug/{name}", thumbnail=png())


def reject(path: str = "a.glb", code: str = "SRC003", word: str = "cannot be read") -> RejectedRow:
    failed = CheckResult(code="GEO001", status=Status.FAILED, number=3.0, limit=1.0, unit="m")
    described: dict[str, Any] = {
        "accepted": False,
        "summary": None,
        "source": "folder",
        "source_path": path,
        "code": code,
        "category": "mug",
        "results": (failed,),
    }
    return RejectedRow(Entry(**{**BLANK, **described}), word, word, word, png())


def page(text: str) -> lxml.html.HtmlElement:
    return lxml.html.document_fromstring(text)


def facts(text: str) -> Any:
    """What the page's script reads."""
    return json.loads(page(text).get_element_by_id("data").text_content())


def tile(text: str, name: str) -> str:
    """The large number in a tile of the summary."""
    return str(page(text).xpath(f"//div[@class='tile {name}']//strong")[0].text_content())


def test_the_numbers_at_the_top() -> None:
    text = render_page(
        [entry(), entry("mug_0000000002", 1.0, warned=True)],
        [reject(), reject("b.glb"), reject("c.glb", "SRC001")],
        "Run",
        {},
    )
    assert tile(text, "accepted") == "2"
    assert tile(text, "rejected") == "3"
    assert tile(text, "warned") == "1"
    assert tile(text, "checks") == "2"
    assert tile(text, "categories") == "1"
    assert tile(text, "mass") == "1.25 kg"


def test_the_facts_of_an_asset_are_all_there() -> None:
    told = facts(render_page([entry()], [reject()], "Run", {"AST001": "reason"}))
    asset = told["assets"][0]
    assert asset["size"] == [8.0, 10.0, 9.55]
    assert asset["files"] == [
        ["MJCF", "./mug/mug_0000000001/model.xml"],
        ["scene", "./mug/mug_0000000001/scene.xml"],
        ["USD", "./mug/mug_0000000001/usd/mug_0000000001.usda"],
        ["certificate", "./mug/mug_0000000001/asset.json"],
    ]
    assert [told["checks"][r[0]] + r[1:] for r in asset["results"]] == [
        ["AST001", "m", "reason", False, 1, 0.123457, 1.0, ""],
        ["AST002", "", "", False, 0, None, None, ""],
        ["KIN001", "", "", False, 2, None, None, asset["title"]],
        ["USD003", "", "", False, 3, None, None, asset["title"]],
    ]
    assert [told["checks"][f[0]][0] for f in told["rejects"][0]["failed"]] == ["GEO001"]


def test_hostile_text_stays_text() -> None:
    text = render_page(
        [entry(word=HOSTILE, warned=True)], [reject(HOSTILE, word=HOSTILE)], HOSTILE, {"AST001": HOSTILE}
    )
    tree = page(text)
    plain = page(render_page([entry()], [reject()], "Run", {}))
    assert [e.tag for e in tree.iter()] == [e.tag for e in plain.iter()]
    assert tree.xpath("//h1")[0].text_content() == HOSTILE
    told = facts(text)
    assert told["assets"][0]["title"] == told["rejects"][0]["reason"] == HOSTILE
    assert "<script>alert" not in text


@pytest.mark.parametrize(
    ("folder", "link"),
    [
        ("javascript:alert(1)", "./javascript%3Aalert%281%29/model.xml"),
        ("//evil.example/a b#?%", "./evil.example/a%20b%23%3F%25/model.xml"),
    ],
)
def test_links_are_relative_whatever_they_are_called(folder: str, link: str) -> None:
    odd = dataclasses.replace(entry(), folder=folder)
    assert facts(render_page([odd], [], "Run", {}))["assets"][0]["files"][0][1] == link


def test_nothing_is_fetched() -> None:
    text = render_page([entry()], [reject()], "Run", {})
    tree = page(text)
    assert not re.findall(r"(?:https?:)?//[a-z0-9.-]+\.[a-z]{2,}", text.replace("data:image", ""))
    assert not tree.xpath("//link | //iframe | //script[@src] | //img[@src]")
    assert "@import" not in text
    assert "url(" not in text
    assert "default-src 'none'" in tree.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0]


def test_the_script_never_writes_markup() -> None:
    script = page(render_page([], [], "Run", {})).xpath("//script[not(@type)]")[0].text_content()
    for word in ("innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "fetch(", "XMLHttp"):
        assert word not in script


def test_the_same_page_whatever_the_order() -> None:
    entries, rejects = [entry(f"mug_{i:010x}") for i in range(4)], [reject(f"{i}.glb") for i in range(3)]
    assert render_page(entries, rejects, "Run", {}) == render_page(entries[::-1], rejects[::-1], "Run", {})


def test_an_empty_run_is_a_page_too() -> None:
    text = render_page([], [], "Nothing", {})
    assert tile(text, "accepted") == "0"
    assert facts(text) == {"assets": [], "checks": [], "rejects": []}


def test_every_id_is_unique_and_every_control_has_a_name() -> None:
    tree = page(render_page([entry()], [reject()], "Run", {}))
    ids = tree.xpath("//@id")
    assert len(ids) == len(set(ids))
    for name in tree.xpath("//@aria-labelledby | //@aria-controls"):
        assert name in ids
    assert all(b.text_content().strip() or b.get("aria-label") for b in tree.xpath("//button"))
    assert all(i.getparent().tag == "label" for i in tree.xpath("//input"))


def test_three_thousand_pictures_fit(tmp_path: Path) -> None:
    assert thumbnail_of(tmp_path) == b""
    noise = Image.effect_noise((512, 512), 40).convert("RGB")
    out = io.BytesIO()
    noise.save(out, "PNG")
    # Noise is the worst there is, a mug on paper takes a fifth of it.
    (tmp_path / "preview.png").write_bytes(out.getvalue())
    assert len(thumbnail_of(tmp_path)) < 22_000
    (tmp_path / "preview.png").write_bytes(png())
    assert 0 < len(thumbnail_of(tmp_path)) < 1_500


def test_what_is_said_of_the_library_as_a_whole_is_text() -> None:
    issues = (Issue(code="LIB001", severity=Severity.WARNING, pointer=HOSTILE, message=HOSTILE),)
    results = (
        CheckResult(code="LIB001", status=Status.FAILED, number=0.004, limit=0.025),
        CheckResult(code="LIB002", status=Status.PASSED),
        CheckResult(code="LIB003", status=Status.NOT_RUN, reason="no weights"),
    )
    told = render_library_section(
        Report(subject="library", results=results, issues=issues), {"LIB001": HOSTILE}, HOSTILE
    )
    tree = lxml.html.fromstring(render_page([entry()], [], "Run", {}, told))
    (found,) = tree.xpath("//section[@class='whole']")
    assert [e.text for e in found.xpath(".//em")] == ["1 found", "passed", "not run: no weights"]
    assert found.xpath(".//script | .//img") == []
    assert render_library_section(None, {}) == render_library_section(Report(subject="library"), {}) == ""
