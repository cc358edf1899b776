"""The site of docs/ in a real browser, opened from a folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.consumers.test_site import build
from tests.support.program.browser import Browser

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = build(folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.mark.parametrize("dark", [False, True])
def test_it_is_searched_without_a_server(site: Path, browser: Browser, dark: bool) -> None:
    page = browser.open(site / "index.html", dark=dark)
    page.click("input.md-search__input")
    page.wait("text=Type to start searching")  # the index is read
    page.fill("input.md-search__input", "parking place")
    page.press("End", "input.md-search__input")  # it searches when a key is let go
    page.wait(".md-search-result__item a")
    found = page.evaluate("[...document.querySelectorAll('.md-search-result__item a')].map(a => a.href)")
    assert any("scene_json.html" in address for address in found), found
    page.click(".md-search-result__item a")
    page.wait("h1")
    assert page.errors == []
    assert page.strange_requests == []
