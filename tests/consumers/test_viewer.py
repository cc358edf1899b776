"""Models in 3D and the page of `casa-assets view` in a real browser: doors, states, styles, without an error."""

from __future__ import annotations

import itertools
import json
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from casa_assets.formats.gltf import asset_glb, scene_glb
from casa_assets.layouts.run.check import check_one
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.scene import Scene
from casa_assets.show.page import page_template
from casa_assets.show.page.page_template import ModelFiles, put_model, put_viewer
from casa_assets.show.reports import catalogue
from casa_assets.show.reports.catalogue import category_row
from casa_assets.show.view.model import make
from casa_assets.show.view.server import ViewServer
from casa_assets.show.view.subject import AssetFolder, find
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import EVERY, microwave
from tests.support.kitchen.scenes import corner
from tests.support.library.libraries import ran
from tests.support.library.server_requests import serving
from tests.support.program.browser import HOME, Browser, Page

pytestmark = pytest.mark.consumers
READY = ".cv[data-state=ready]"
# The viewer is what `openModel` resolves to; tests keep it by this name.
OPEN = "openModel(document.querySelector('.model')).then(shown => { window.shown = shown; return shown !== null; })"

TEMPLATE = """{% extends "frame/base.html" %}
{% from "model/model.html" import model_box %}
{% block more_policy %}; {{ model_policy }}{% endblock %}
{% block content %}
{{ model_box(model, title, "") }}
{% endblock %}
{% block scripts %}<script>
{{ source("model/model.js") }}
</script>{% endblock %}
"""


def page_of(folder: Path, name: str, glb: bytes) -> Path:
    """A page with one model, as the pages of the project have them."""
    files = ModelFiles(name, put_model(folder, name, glb), put_viewer(folder))
    page = folder / f"{name}.html"
    template = page_template._environment().from_string(TEMPLATE)
    page.write_text(template.render(title=name, model=files, version="0"), encoding="utf-8")
    return page


def opened(browser: Browser, page: Path, **how: Any) -> Page:
    shown = browser.open(page, **how)
    assert shown.evaluate(OPEN)
    shown.wait(READY)
    return shown


def joints(page: Page) -> dict[str, dict[str, Any]]:
    return {joint["name"]: joint for joint in page.evaluate("shown.jointFacts()")}


def place_of(page: Page, node: str) -> tuple[float, float]:
    """Pixels of the window at which the middle of what a node shows is seen."""
    x, y = page.evaluate(
        f"""(() => {{
          const undo = shown.addLabels([{{ text: "x", node: {json.dumps(node)} }}], () => null);
          shown.stage.draw(performance.now());
          const box = document.querySelector(".cv-label").getBoundingClientRect();
          undo();
          return [box.x + box.width / 2, box.y + box.height / 2];
        }})()"""
    )
    return x, y


@pytest.fixture(scope="module")
def oven_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    asset = microwave()
    return page_of(tmp_path_factory.mktemp("oven"), asset.id, asset_glb(asset, with_layers=True))


def test_a_door_opens_by_slider_by_button_and_by_click(browser: Browser, oven_page: Path) -> None:
    page = browser.open(oven_page)
    loaded = "performance.getEntriesByType('resource').length + document.querySelectorAll('script[src]').length"
    assert page.evaluate(loaded) == 0, "nothing is loaded before somebody asks"
    page = opened(browser, oven_page)
    (name,) = [joint["name"] for joint in joints(page).values() if joint["type"] == "hinge"]
    door = joints(page)[name]
    assert door["position"] == pytest.approx(door["closed"])
    # By keyboard on the slider: End is open, whichever way the joint counts.
    page.press("End", f'[data-joint="{name}"] input')
    assert joints(page)[name]["position"] == pytest.approx(door["open"], abs=0.02)
    assert page.texts(f'[data-joint="{name}"] output')[0].endswith("°")
    page.click(f'[data-joint="{name}"] button')
    page.pause(2.0)
    assert joints(page)[name]["position"] == pytest.approx(door["closed"], abs=1e-3)
    page.click_at(*place_of(page, "door"))
    page.pause(2.0)
    assert joints(page)[name]["position"] == pytest.approx(door["open"], abs=1e-3)
    assert page.texts(f'[data-joint="{name}"] button') == ["Close"]
    page.assert_clean()
    # On a phone in the dark.
    page = opened(browser, oven_page, width=390, height=844, dark=True, touch=True)
    assert page.fits
    page.tap_at(*place_of(page, "door"))
    page.pause(2.0)
    assert joints(page)[name]["position"] == pytest.approx(door["open"], abs=1e-3)
    page.assert_clean()


def test_poses_and_layers(browser: Browser, tmp_path: Path) -> None:
    asset = grill()
    page = opened(browser, page_of(tmp_path, asset.id, asset_glb(asset, with_layers=True)))
    for key in asset.keyframes:
        page.click(f'.cv-button:text-is("{key.name.replace("_", " ").capitalize()}")')
        page.pause(2.0)
        wanted = {at.joint: at.value for at in key.joints}
        for name, joint in joints(page).items():
            assert joint["position"] == pytest.approx(wanted.get(name, 0.0), abs=1e-3)
    before = page.evaluate("shown.picture()")
    page.click("text=Colliders")
    assert {one["name"]: one["isShown"] for one in page.evaluate("shown.layers()")}["collider"]
    assert page.evaluate("shown.picture()") != before
    page.assert_clean()


def test_it_turns_by_mouse_wheel_and_keys(browser: Browser, oven_page: Path) -> None:
    page = opened(browser, oven_page)
    where = "(() => { const c = shown.stage.camera.position; return [c.x, c.y, c.z]; })()"
    seen = [page.evaluate(where)]
    x, y = page.evaluate("(({ x, y }) => [x + 60, y + 200])(document.querySelector('canvas').getBoundingClientRect())")
    page.drag(x, y, x + 120, y + 30)
    seen.append(page.evaluate(where))
    page.wheel(x, y, -200)
    page.pause(0.5)
    seen.append(page.evaluate(where))
    for key in ("ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+"):
        page.press(key, "canvas")
        seen.append(page.evaluate(where))
    assert all(a != pytest.approx(b, abs=1e-6) for a, b in itertools.pairwise(seen))
    page.press("0", "canvas")
    assert page.evaluate(where) == pytest.approx(seen[0], abs=1e-4)
    page.assert_clean()


def test_what_cannot_be_loaded_is_shown(browser: Browser, tmp_path: Path) -> None:
    page = browser.open(page_of(tmp_path, "gone", b"glTF"))
    (tmp_path / "gone.glb.js").unlink()
    page.click(".model-open")
    page.wait("role=alert")
    assert "cannot be read" in page.texts("[role=alert]")[0]


def test_the_page_of_a_kitchen(browser: Browser, tmp_path: Path) -> None:
    """As `scenes check` leaves it: the model comes in place of the picture, is turned, and a door opens."""
    done = check_one(SceneRecipe("one_wall_small", "coastal"), tmp_path / "scenes")
    assert done.passed, done.message
    page = browser.open(Path(done.folder) / "report.html")
    page.assert_clean()
    assert page.evaluate(OPEN)
    page.wait(READY)
    assert page.evaluate("shown.cameras().includes('overview')")
    page.fill(".cv-search", "fridge door")
    rows = page.texts(".cv-joint label")
    assert rows
    assert all("door" in row.lower() for row in rows)
    page.click(".cv-joint:visible .cv-toggle")
    page.pause(3.0)
    moved = [joint for joint in joints(page).values() if abs(joint["position"] - joint["closed"]) > 0.1]
    assert len(moved) == 1
    page.assert_clean()


def test_a_member_of_a_catalogue_in_a_dialog(browser: Browser, tmp_path: Path) -> None:
    asset = grill()
    script = f"models/{put_model(tmp_path / 'models', 'apple_0', asset_glb(asset, with_layers=True))}"
    model = ModelFiles("apple_0", script, f"models/{put_viewer(tmp_path / 'models')}")
    row = category_row("apple", "objects/apple.webp", (0.15,), (0.071,), (900,), (1,), (model,))
    (tmp_path / "index.html").write_text(catalogue.page([], [row], {}), encoding="utf-8")
    (tmp_path / "objects").mkdir()
    Image.new("RGB", (144, 144), (180, 40, 30)).save(tmp_path / "objects" / "apple.webp")
    page = browser.open(tmp_path / "index.html")
    page.click('role=button[name="apple 1 in 3D"]')
    page.wait(f"dialog {READY}")
    page.assert_clean()
    page.press("Escape")
    page.pause(0.5)
    assert page.evaluate("document.querySelectorAll('dialog').length") == 0
    assert page.evaluate("document.activeElement.dataset.name") == "apple_0"
    page.assert_clean()


@pytest.mark.parametrize("build", [*EVERY, grill, corner])
def test_the_khronos_validator_finds_no_error(build: Callable[[], Asset | Scene], tmp_path: Path) -> None:
    made = build()
    glb = scene_glb(made, with_layers=True) if isinstance(made, Scene) else asset_glb(made, with_layers=True)
    (tmp_path / "model.glb").write_bytes(glb)
    script = (
        "const {validateBytes} = require('gltf-validator'), fs = require('fs');"
        "validateBytes(new Uint8Array(fs.readFileSync(process.argv[1]))).then(r => console.log(JSON.stringify("
        "r.issues.messages.filter(m => m.severity === 0).map(m => `${m.pointer}: ${m.message}`))))"
    )
    assert json.loads(ran("node", "-e", script, tmp_path / "model.glb", cwd=HOME / "node").stdout) == []


def test_the_bundle_is_what_its_sources_build(tmp_path: Path) -> None:
    """Built again from the sources with the packages of the lock: the same bytes as those that are committed."""
    bundle, work, out = Path(page_template.__file__).with_name("bundle"), tmp_path / "work", tmp_path / "out"
    shutil.copytree(bundle, work)
    (work / "node_modules").symlink_to(HOME / "node" / "node_modules")
    out.mkdir()
    ran("node", "build.mjs", out, cwd=work, timeout=120)
    for name in ("viewer.js", "LICENSES.txt"):
        assert (out / name).read_bytes() == (bundle / name).read_bytes()


PATIENCE_S = 240.0


@pytest.fixture(scope="module")
def kitchen(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[ViewServer]:
    subject = find("one_wall_small__coastal", tmp_path_factory.mktemp("scenes"), ())
    with serving(subject, lambda s, tell: make(s, cache, tell), "on") as server:
        yield server


def shown(browser: Browser, server: ViewServer, **how: bool | int) -> Page:
    page = browser.open(server.address, **how)  # type: ignore[arg-type]
    page.wait("body[data-shown], .progress.bad", PATIENCE_S)
    assert page.texts("#progress") == []
    return page


def wait_until(is_so: Callable[[], bool]) -> None:
    """Wait for what the page asks the server for."""
    end = time.monotonic() + 20.0
    while not is_so():
        assert time.monotonic() < end, "it does not come"
        time.sleep(0.2)


def test_keys_start_and_stop_a_microwave(browser: Browser, cache: Path) -> None:
    with serving(find("microwave/steel", Path("none"), ()), lambda s, tell: make(s, cache, tell)) as server:
        page = shown(browser, server)
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
    changed = "s.value = 'industrial'; s.dispatchEvent(new Event('change'));"
    page.evaluate(f"(s => {{ {changed} }})(document.getElementById('style'))")
    page.wait('body[data-shown="one_wall_small__industrial"], .progress.bad', PATIENCE_S)
    assert page.texts("#progress") == []
    assert page.texts("#title") == ["one_wall_small__industrial"]
    assert "casa-assets scenes build one_wall_small__industrial" in page.texts("#note")[0]
    assert page.evaluate(f"document.querySelector('[data-joint=\"{door}\"] output').textContent") != "0°"
    page.assert_clean()


def test_what_goes_wrong_is_shown_on_the_page(browser: Browser, tmp_path: Path, cache: Path) -> None:
    with serving(AssetFolder(tmp_path / "gone"), lambda s, tell: make(s, cache, tell)) as server:
        page = browser.open(server.address)
        page.wait(".progress.bad")
        assert "asset.json" in page.texts("#progress")[0]
