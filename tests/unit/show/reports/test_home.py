"""The page about a folder of output shows what stands there, and nothing that does not."""

from __future__ import annotations

import json
from pathlib import Path

from lxml import html

from casa_assets.show.reports import home
from casa_assets.show.reports.library_page import write as write_report
from tests.support.library.built_libraries import keep
from tests.unit.library.test_alike import FIRST, OTHER
from tests.unit.show.reports.test_kitchen_pages import scene
from tests.unit.show.reports.test_library_page import refused


def page(out: Path) -> html.HtmlElement:
    return html.document_fromstring(home.write(out).read_text(encoding="utf-8"))


def test_what_stands_there_is_shown_with_links_to_its_pages(tmp_path: Path) -> None:
    assert [h2.text_content() for h2 in page(tmp_path).xpath("//h2")] == ["What to try next"]
    root = keep(tmp_path / "library", [FIRST, OTHER])
    refused(root, "FLT005", "links: 2 large parts stand apart; give each object a file of its own")
    write_report(root, root / "report.html")
    galley = scene(tmp_path / "scenes", "galley", "rustic")
    (galley / "overview.png").write_bytes(b"png")
    (galley / "eye_open.png").write_bytes(b"png")
    scene(tmp_path / "scenes", "l_small", "rustic")
    tree = page(tmp_path)
    links = set(tree.xpath("//main//a/@href"))
    assert {"./scenes/index.html#galley__rustic", f"./library/report.html#{FIRST.id}"} <= links
    assert "./scenes/galley__rustic/eye_open.png" in tree.xpath("//img/@src")
    text = " ".join(tree.xpath("//main")[0].text_content().split())
    assert "2 accepted, 1 rejected" in text
    assert "was rejected: FLT005" in text
    assert "Give each object a file of its own." in text
    assert "casa-assets scenes check galley__rustic" in text


def test_what_was_articulated_is_told_with_its_joints(tmp_path: Path) -> None:
    root = keep(tmp_path / "articulated", [FIRST])
    path = root / "mug" / FIRST.id / "asset.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    data["certificate"]["producer"] = "articulate"
    path.write_text(json.dumps(data), encoding="utf-8")
    (path.parent / "strip.png").write_bytes(b"png")
    tree = page(tmp_path)
    assert [h2.text_content() for h2 in tree.xpath("//h2")] == ["Articulated", "What to try next"]
    assert tree.xpath("//img/@src") == [f"./articulated/mug/{FIRST.id}/strip.png"]
    assert "0 joints" in tree.xpath("//div[@class='wide']")[0].text_content()
