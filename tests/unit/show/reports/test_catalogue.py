"""The catalogue: what it shows, what it says of a category of objects, and by which words that is found."""

from __future__ import annotations

from lxml import html

from casa_assets import registry
from casa_assets.show.page.page_template import ModelFiles
from casa_assets.show.reports.catalogue import SOURCES, category_row, page

APPLE = category_row("apple", "objects/apple.webp", (0.15, 0.21), (0.071, 0.08), (900, 1100), (1, 3))
MUG = category_row("mug", "objects/mug.webp", (0.3,), (0.12,), (2000,), (8,))


def articles() -> dict[str, html.HtmlElement]:
    tree = html.document_fromstring(page([], [APPLE, MUG], {}))
    return {article.xpath("h2/@id")[0]: article for article in tree.xpath("//article")}


def test_sizes_and_masses_stand_beside_the_usual_ones_with_their_source() -> None:
    article, apple = articles()["apple"], registry.load().categories["apple"]
    length, mass = [[cell.text_content() for cell in row.xpath("td")] for row in article.xpath("table//tr[td]")]
    assert length[:2] == ["longest side, cm", "7.1 to 8"]
    assert mass[:2] == ["mass, g", "150 to 210"]
    low, high, typical = (1000 * kg for kg in (apple.mass_kg.low, apple.mass_kg.high, apple.mass_kg.typical))
    assert mass[2] == f"{low:g} to {high:g}, typically {typical:g}"
    assert [length[3], mass[3]] == [SOURCES[apple.basis.size], SOURCES[apple.basis.mass]]
    assert "1000 faces, 2 collision shapes" in article.text_content(), "medians"
    image = article.xpath(".//img")[0]
    assert (image.get("loading"), image.get("src")) == ("lazy", "./objects/apple.webp")


def test_members_that_have_a_model_have_a_button_that_shows_it() -> None:
    assert articles()["apple"].xpath(".//button") == []
    files = tuple(ModelFiles(f"mug_{i}", f"models/mug_{i}.glb.js", "models/viewer.js") for i in range(2))
    tree = html.document_fromstring(page([], [{**MUG, "models": files}], {}))
    buttons = tree.xpath("//article//button")
    assert [b.get("data-model") for b in buttons] == ["./models/mug_0.glb.js", "./models/mug_1.glb.js"]
    assert [b.get("aria-label") for b in buttons] == ["mug 1 in 3D", "mug 2 in 3D"]
    assert {b.get("data-viewer") for b in buttons} == {"./models/viewer.js"}
