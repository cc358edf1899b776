"""The keys of the page of review for articulated meshes, pressed in Node.js, and the decisions that come of them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from casa_assets.articulate.decisions import Decisions
from casa_assets.articulate.run import review_page
from casa_assets.articulate.run.build import ArticulateRequest, build
from casa_assets.articulate.run.steps import ArticulateOutcome
from casa_assets.checks.motion.joints import JointTravel
from casa_assets.library.mesh_decisions import read_review
from tests.support.library.libraries import ran
from tests.unit.articulate.blocks import microwave
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.consumers
SHA256 = "1" * 64
# Parts of the mesh, in their order on the page.
FIRST, SECOND = "door_0", "button_0"


def reviewed_page(place: Path) -> Path:
    """The page of a microwave with a door hinged at the left, in a folder."""
    vertices, faces, _ = microwave()
    mesh = obj(place / "microwave.obj", vertices, faces)
    built = build(ArticulateRequest(mesh, place, up=(0, 0, 1), front=(0, -1, 0)))
    travels = {part.name: JointTravel(part.name, 1.0, "", 1.0) for part in built.articulation.parts}
    done = ArticulateOutcome(mesh, place / "x", built.articulation, "microwave", travels=travels, sha256=SHA256)
    assert [part.name for part in built.articulation.parts[:2]] == [FIRST, SECOND]
    return review_page.write(place, [done], "casa-assets articulate in --decisions review.json")


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return reviewed_page(tmp_path_factory.mktemp("page"))


def press(page: Path, *keys: str) -> Decisions:
    done = ran("node", Path(__file__).with_name("press_keys.js"), page, *keys, "w")
    file = page.with_name("review.json")
    file.write_text(done.stdout, encoding="utf-8")
    return read_review(file).get(SHA256, Decisions())


@pytest.mark.parametrize(
    ("keys", "parts"),
    [
        ("", {}),
        ("h", {FIRST: {"hinge": "another"}}),
        ("hhhh", {FIRST: {"hinge": "left"}}),
        ("r", {FIRST: {"remove": True}}),
        ("rr", {}),
        ("nf", {SECOND: {"flip": True}}),
        ("n1", {SECOND: {"kind": "door"}}),
        ("n1hz", {SECOND: {"kind": "door"}}),
        ("ngpg", {SECOND: {"merge": FIRST}}),
        ("ngpgz", {}),
        ("gg", {}),
        ("9", {FIRST: {"remove": True}}),
        ("h2", {FIRST: {"kind": "drawer"}}),
    ],
)
def test_keys_make_decisions_on_parts(page: Path, keys: str, parts: dict[str, Any]) -> None:
    found = press(page, *keys).model_dump(mode="json", exclude_defaults=True).get("parts", {})
    if keys == "h":
        assert found[FIRST]["hinge"] in ("right", "top", "bottom")
    else:
        assert found == parts


def test_buttons_do_what_their_keys_do_and_some_decide_on_a_mesh(page: Path) -> None:
    buttons = re.findall(r'<button [^>]*data-key="(.)"', page.read_text(encoding="utf-8"))
    assert buttons == [*"kjaxzw", *"hfgr"]
    assert press(page, "button:r") == press(page, "r")
    assert press(page, "button:a", "button:z") == Decisions()
    assert press(page, "a").decision == "accept"
    assert press(page, "a", "x").decision == "reject"
    assert press(page, "u", "u").up == "-x"
    assert press(page, "a", "z") == Decisions()
