"""From the page of review to the asset: what it shows, the review.json that it writes, and the run that obeys it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from casa_assets.articulate.plan import HingeEdge
from casa_assets.articulate.run.review_page import NAME
from casa_assets.cli.main import app
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.library.entry_files import read_asset
from casa_assets.library.library import Library
from casa_assets.library.mesh_decisions import mesh_decisions, read_review
from casa_assets.model.asset.parts import JointKind
from casa_assets.show.view.review import ReviewServer
from tests.support.library.server_requests import ask, running
from tests.unit.articulate.blocks import drawers, microwave
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate.run", keep=0)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`in` with a microwave and a chest of drawers, and `lib`, made of it, with the page."""
    place = tmp_path_factory.mktemp("place")
    (place / "in").mkdir()
    for name, (vertices, faces, _) in {"microwave": microwave(), "<b>drawers": drawers()}.items():
        obj(place / "in" / f"{name}.obj", vertices, faces)
    articulate(place, "--review")
    return place


def articulate(place: Path, *options: str) -> str:
    words = ["articulate", str(place / "in"), "--library", str(place / "lib"), "--up=+z", "--front=-y", "--size-m=0.5"]
    result = CliRunner().invoke(app, [*words, *options])
    assert result.exit_code in (0, 4), result.output
    return result.output


def facts(place: Path) -> dict[str, Any]:
    """What the page of a library shows, by the name of the mesh."""
    return facts_of((place / "lib" / NAME).read_text(encoding="utf-8"))


def facts_of(page: str) -> dict[str, Any]:
    """What a page shows, by the name of the mesh."""
    match = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert "<b>drawers" not in page
    return {row["name"]: row for row in json.loads(match[1])["rows"]}


def test_the_page_shows_each_part_with_its_picture(place: Path) -> None:
    row = facts(place)["microwave.obj"]
    parts = {part["name"]: part for part in row["parts"]}
    assert parts["door_0"]["corner"] is not None
    assert parts["knob_0"]["corner"] is None
    assert parts["door_0"]["edge"] == "left"
    assert (place / "lib" / row["strip"]).is_file()
    assert {"closed", "parts", "taken apart"} <= row["corners"].keys()
    assert row["decisions"] == {}
    model = (place / "lib" / row["model"]["script"]).read_text(encoding="ascii")
    assert model.startswith(f'casaModel("{row["model"]["name"]}"'), "the page shows it in 3D"
    assert (place / "lib" / row["model"]["viewer"]).is_file()
    assert parts["door_0"]["joint_name"] == "microjoint"


def test_a_part_has_one_confidence_in_all_files_and_on_the_page(place: Path) -> None:
    """On the page, in asset.json and decisions.yaml beside it, and in what --json and --report print."""
    rows = {row["path"]: row for row in map(json.loads, articulate(place, "--json").splitlines())}
    report = articulate(place, "--report")
    for name, row in facts(place).items():
        folder = next((place / "lib").glob(f"*/{rows[name]['id']}"))
        guesses = {guess.subject: guess.confidence for guess in read_asset(folder).provenance.guesses}
        decisions = (folder / "decisions.yaml").read_text(encoding="utf-8")
        assert rows[name]["parts"]
        for part in rows[name]["parts"]:
            sure = part["confidence"]
            shown = next(one["confidence"] for one in row["parts"] if one["name"] == part["name"])
            assert shown == sure == guesses[part["name"]]
            assert re.search(rf"^  {part['name']}:  # {sure:.0%} sure", decisions, re.MULTILINE)
            assert re.search(rf"^{part['name']} .* {sure:.0%} ", report, re.MULTILINE)
        assert not re.search(r"hinge: .*% sure", decisions)


def test_what_the_page_writes_is_obeyed_by_this_run_and_later_ones(place: Path) -> None:
    sha256 = facts(place)["microwave.obj"]["sha256"]
    parts = {
        "door_0": {"hinge": "bottom"},
        "knob_0": {"remove": True},
        "button_0": {"merge": "button_1"},
        "button_2": {"kind": "lever"},
        "button_3": {"flip": True},
    }
    file = place / "review.json"
    # The size is given for all meshes; what is decided about one goes before it.
    said = {"decision": "accept", "parts": parts, "size_m": 0.6}
    file.write_text(json.dumps({"meshes": {sha256: said}}), encoding="utf-8")
    output = articulate(place, "--review", "--decisions", str(file))
    row = facts(place)["microwave.obj"]
    assert row["decisions"]["parts"] == parts
    assert {part["name"] for part in row["parts"]} == {"door_0", "button_1", "button_2", "button_3"}
    assert row["status"] == "accepted"
    (folder,) = (place / "lib" / "microwave").iterdir()
    asset = read_asset(folder)
    assert max(asset.bounds[1] - asset.bounds[0]) == pytest.approx(0.6, rel=0.01)
    assert sum(joint.kind is JointKind.HINGE for joint in asset.joints) == 2, "the door, and what was a button"
    assert [j.axis[1] for j in asset.joints if j.kind is JointKind.SLIDE] == [1.0, -1.0], "one key was flipped"
    assert "1 was there already" in output, "nothing was decided about the drawers"
    assert "2 were there already" in articulate(place), "the decisions are those of the library now"
    # What is undone on the page is given back as nothing.
    file.write_text(json.dumps({"meshes": {sha256: {}}}), encoding="utf-8")
    articulate(place, "--review", "--decisions", str(file))
    assert len(facts(place)["microwave.obj"]["parts"]) == 6
    assert mesh_decisions(Library(place / "lib")) == {}


def test_a_strip_is_drawn_for_what_an_earlier_run_made_without(place: Path, tmp_path: Path) -> None:
    before = {path: path.read_bytes() for path in (place / "lib").glob("*/*/asset.json")}
    for path in before:
        (path.parent / "strip.png").unlink(missing_ok=True)
    assert "2 were there already" in articulate(place, "--preview")
    for path, data in before.items():
        assert (path.parent / "strip.png").is_file()
        assert path.read_bytes() == data


def test_a_review_file_that_means_nothing_is_told_with_its_line(tmp_path: Path) -> None:
    path, sha256 = tmp_path / "review.json", "0" * 64
    path.write_text(json.dumps({"meshes": {sha256: {"parts": {"door_0": {"hinge": "middle"}}}}}, indent=1))
    with pytest.raises(RegistryError, match=r"review.json:6: meshes.*hinge"):
        read_review(path)
    path.write_text(json.dumps({"meshes": {sha256: {"category": "no_such_thing"}}}), encoding="utf-8")
    with pytest.raises(UnknownId):
        read_review(path)


def test_a_page_that_is_served_writes_into_the_library(place: Path) -> None:
    with running(ReviewServer(Library(place / "lib"))) as server:
        status, page = ask(server, f"/{server.token}/articulated")
        assert status == 200
        assert b"microwave.obj" in page
        row = facts(place)["microwave.obj"]
        status, picture = ask(server, f"/{server.token}/{row['strip'].removeprefix('./')}")
        assert (status, picture[:4]) == (200, b"\x89PNG")
        model = facts_of(page.decode())["microwave.obj"]["model"]
        status, script = ask(server, f"/{server.token}/{model['script'].removeprefix('./')}")
        assert (status, script) == (200, (place / "lib" / row["model"]["script"]).read_bytes())
        assert ask(server, f"/{server.token}/{model['viewer'].removeprefix('./')}")[0] == 200
        assert ask(server, f"/{server.token}/models/another.glb.js")[0] == 404
        assert ask(server, f"/{server.token}/microwave/../../in/microwave.obj")[0] == 404
        address = f"/{server.token}/decide_articulated"
        said = {"sha256": row["sha256"], "decisions": {"parts": {"door_0": {"hinge": "top"}}}}
        assert ask(server, address, {**said, "decisions": {"parts": {"door_0": {"hinge": "middle"}}}})[0] == 400
        assert ask(server, address, {**said, "decisions": {"category": "no_such_thing"}})[0] == 400
        assert ask(server, "/wrong/decide_articulated", said)[0] == 400
        assert mesh_decisions(server.library) == {}
        assert ask(server, address, said)[0] == 200
        assert mesh_decisions(server.library)[row["sha256"]].parts["door_0"].hinge is HingeEdge.TOP
        assert ask(server, address, {**said, "decisions": {}})[0] == 200
        assert mesh_decisions(server.library) == {}
