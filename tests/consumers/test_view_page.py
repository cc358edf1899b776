"""The page of `casa-assets view` in a real browser: doors, states, styles, robots' places, without an error."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from casa_assets.show.view.model import make
from casa_assets.show.view.server import ViewServer
from casa_assets.show.view.subject import AssetFolder, find
from tests.support.library.server_requests import serving
from tests.support.program.browser import Browser, Page

pytestmark = pytest.mark.consumers
KITCHEN = "one_wall_small__coastal"
PATIENCE_S = 240.0


@pytest.fixture(scope="module")
def microwave(cache: Path) -> Iterator[ViewServer]:
    with serving(find("microwave/steel", Path("none"), ()), lambda s, tell: make(s, cache, tell)) as server:
        yield server


@pytest.fixture(scope="module")
def kitchen(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ViewServer]:
    subject = find(KITCHEN, tmp_path_factory.mktemp("scenes"), ())
    with serving(subject, lambda s, tell: make(s, cache, tell), "on") as server:
        yield server


def shown(browser: Browser, server: ViewServer, **how: bool | int) -> Page:
    """The page once its model is seen."""
    page = browser.open(server.address, **how)  # type: ignore[arg-type]
    page.wait("body[data-shown], .progress.bad", PATIENCE_S)
    assert page.texts("#progress") == []
    return page


def wait_until(is_so: Callable[[], bool]) -> None:
    """Wait for what the page asks the server for. Raises AssertionError where it does not come."""
    end = time.monotonic() + 20.0
    while not is_so():
        assert time.monotonic() < end, "it does not come"
        time.sleep(0.2)


def test_keys_start_and_stop_a_microwave(browser: Browser, microwave: ViewServer) -> None:
    page = shown(browser, microwave)
    assert page.texts(".state") == ["lamp: off", "power: off"]
    page.click("text=press start button")
    wait_until(lambda: "power: on" in page.texts(".state"))
    assert "spin" in " ".join(page.texts(".state.acts"))
    page.click("text=press stop button")
    wait_until(lambda: "power: off" in page.texts(".state"))
    page.press("End", '[data-joint="microjoint"] input')
    wait_until(lambda: "lamp: on" in page.texts(".state"))
    page.assert_clean()


def test_a_pose_lights_burners_and_a_knob_puts_one_out(browser: Browser, kitchen: ViewServer) -> None:
    page = shown(browser, kitchen)
    page.click("#states_section > summary")
    wait_until(lambda: page.texts(".thing.acts summary") != [])
    (stove,) = [name for name in page.texts(".thing.acts summary") if "range" in name or "hob" in name]
    page.click(f'#states summary:text-is("{stove}")')
    lit = len(page.texts(".state.acts"))
    assert lit > 1
    knob = f'[data-joint^="{stove.replace(" ", "_")}/"][data-words*="knob"] input'
    page.fill(".cv-search", f"{stove} knob")
    page.press("Home", knob)
    wait_until(lambda: len(page.texts(".state.acts")) < lit)
    # Names of things, and where robots park.
    assert page.texts(".cv-label") == []
    page.click("#mark_labels")
    assert any("fridge" in name for name in page.texts(".cv-label"))
    page.click("#mark_parking")
    page.click("#mark_labels")
    page.pause(0.5)
    page.assert_clean()


def test_another_style_takes_its_place_with_the_doors_as_they_stood(browser: Browser, kitchen: ViewServer) -> None:
    page = shown(browser, kitchen)
    page.fill(".cv-search", "fridge door")
    door = page.evaluate("[...document.querySelectorAll('.cv-joint')].find(e => e.checkVisibility()).dataset.joint")
    page.press("End", f'[data-joint="{door}"] input')
    page.click("#swap summary")
    page.evaluate(
        "(s => { s.value = 'industrial'; s.dispatchEvent(new Event('change')); })(document.getElementById('style'))"
    )
    page.wait('body[data-shown="one_wall_small__industrial"], .progress.bad', PATIENCE_S)
    assert page.texts("#progress") == []
    assert page.texts("#title") == ["one_wall_small__industrial"]
    assert "casa-assets scenes build one_wall_small__industrial" in page.texts("#note")[0]
    (angle,) = page.evaluate(
        f"[...document.querySelectorAll('[data-joint=\"{door}\"] output')].map(e => e.textContent)"
    )
    assert angle != "0°"
    page.assert_clean()


def test_what_goes_wrong_is_shown_on_the_page(browser: Browser, tmp_path: Path, cache: Path) -> None:
    with serving(AssetFolder(tmp_path / "gone"), lambda s, tell: make(s, cache, tell)) as server:
        page = browser.open(server.address)
        page.wait(".progress.bad")
        assert "asset.json" in page.texts("#progress")[0]
