"""`casa-assets view` and the page of review: what names mean, what is served and to whom; steps of state machines."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from casa_assets.errors import CasaError, OutputError, UnknownId
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import draw_surfaces
from casa_assets.library.entry import entries
from casa_assets.library.library import Library
from casa_assets.library.review import read_overrides
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.choices import Surface
from casa_assets.show.page.page_template import viewer_name, viewer_script
from casa_assets.show.view import model as machines
from casa_assets.show.view import server as view_server
from casa_assets.show.view.model import Model, ShowProgress, build_command, make
from casa_assets.show.view.review import ReviewServer
from casa_assets.show.view.server import KEPT, ViewServer
from casa_assets.show.view.subject import AssetFolder, Kitchen, Member, ModelFile, Subject, find
from tests.support.asset.family_members import preset
from tests.support.library.libraries import BOXES, box_obj
from tests.support.library.server_requests import ask, running, serving

pytestmark = pytest.mark.content("code", "show.view", keep=0)

PATIENCE_S = 60.0


def of_json(answer: tuple[int, bytes]) -> Any:
    """The body of an answer that went well."""
    status, body = answer
    assert status == 200, body
    return json.loads(body)


def wait_for(server: ViewServer, model_id: str) -> dict[str, Any]:
    """Progress of a model that is ready or has failed."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        found: dict[str, Any] = of_json(ask(server, f"progress/{model_id}"))
        if found["is_ready"] or found["error"]:
            return found
        time.sleep(0.05)
    raise AssertionError(f"{model_id} is not made after {PATIENCE_S} s")


@pytest.fixture(scope="module")
def microwave(cache: Path) -> Iterator[ViewServer]:
    """A microwave out of numbers, as the command serves it."""
    with serving(find("microwave/steel", Path("none"), ()), lambda s, tell: make(s, cache, tell), "open") as server:
        assert wait_for(server, "microwave%2Fsteel")["is_ready"]
        yield server


def bare(subject: Subject, tell: ShowProgress) -> Model:
    """A model that costs nothing: of a kitchen whose folder may hold a report."""
    assert isinstance(subject, Kitchen)
    tell("building", 1, 2)
    if subject.recipe.style == "rustic":
        raise CasaError("there is no rustic wood today")
    return Model(subject.id, b"glTF", {"id": subject.id}, {}, subject.folder)


@pytest.fixture
def kitchen(tmp_path: Path) -> Iterator[ViewServer]:
    """A kitchen with a report."""
    folder = tmp_path / "galley__coastal"
    folder.mkdir()
    files = {"report.html": '<p>report <img src="map.png">', "map.png": "a picture that it names", "scene.json": "{}"}
    for name, text in {**files, "notes.txt": "private", "../secret.html": "private"}.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "link.html").symlink_to(tmp_path / "secret.html")
    with serving(Kitchen(SceneRecipe("galley", "coastal"), tmp_path), bare) as server:
        assert wait_for(server, "galley__coastal")["is_ready"]
        yield server


def test_serves_the_page_the_model_and_what_is_known_of_it(microwave: ViewServer) -> None:
    status, page = ask(microwave, "")
    assert status == 200
    assert b'"first":"microwave/steel","pose":"open"' in page
    assert b"://" not in page.split(b"<script")[0]  # nothing of another machine
    status, glb = ask(microwave, "model/microwave%2Fsteel.glb")
    assert (status, glb[:4]) == (200, b"glTF")
    facts = of_json(ask(microwave, "facts/microwave%2Fsteel"))
    assert facts["kind"] == "asset"
    (machine,) = facts["machines"]
    assert (machine["placement"], machine["targets"]["int"]["is"]) == ("", "region")
    assert {"name": "start_button", "joint": "start_button_joint"} in machine["contacts"]
    lamp = machine["targets"]["lamp_visual"]
    assert max(max(face) for face in lamp["faces"]) == len(lamp["points"]) - 1
    assert {"node": "door", "text": "door"} in facts["labels"]
    assert facts["report"] is False
    assert ask(microwave, "order", {"of": "microwave/steel", "style": "rustic"})[0] == 400, "an asset has no styles"


def test_steps_state_machines(microwave: ViewServer) -> None:
    first = of_json(ask(microwave, "step/microwave%2Fsteel", {}))
    kept = {name: first[name] for name in ("values", "before", "held_s")}
    on = of_json(ask(microwave, "step/microwave%2Fsteel", {**kept, "touched": ["start_button"], "dt_s": 0.1}))
    assert on["values"]["power"] == "on"
    assert "spin" in {effect["kind"] for effect in on["effects"]}
    for name, step in (("microwave%2Fsteel", {"placement": "fridge"}), ("nothing", {}), ("microwave%2Fsteel", ["no"])):
        assert ask(microwave, f"step/{name}", step)[0] == 400


def test_answers_its_own_page_alone_and_through_a_tunnel_from_any_port(kitchen: ViewServer) -> None:
    order = {"of": "galley__coastal", "style": "rustic"}
    for host in ("evil.example", "evil.example:80", "192.168.0.7", "", "127.0.0.1.evil.example", "["):
        assert ask(kitchen, "", Host=host)[0] == 403
        assert ask(kitchen, "model/galley__coastal.glb", Host=host)[0] == 403
        assert ask(kitchen, "order", order, Host=host)[0] == 403
    for host in ("localhost:8080", "127.0.0.1:9", "[::1]:9"):
        assert ask(kitchen, "", Host=host)[0] == 200
        assert ask(kitchen, "order", {"of": "galley__coastal"}, Host=host, Origin=f"http://{host}")[0] == 200
    assert ask(kitchen, "order", order, Origin="http://evil.example")[0] == 403
    assert ask(kitchen, "order", order, Content_Type="text/plain")[0] == 403
    assert ask(kitchen, "progress/galley__rustic")[0] == 404
    assert of_json(ask(kitchen, "order", order)) == {"id": "galley__rustic"}


def test_surfaces_are_swapped_and_put_back(kitchen: ViewServer) -> None:
    wall = {"of": "galley__coastal", "surfaces": {"wall": "brick_red_running"}}
    bricks = of_json(ask(kitchen, "order", wall))["id"]
    assert bricks.startswith("galley__coastal__t")
    floor = of_json(ask(kitchen, "order", {"of": bricks, "surfaces": {"floor": "oak_ebony"}}))["id"]
    assert floor not in (bricks, "galley__coastal")
    both = SceneRecipe("galley", "coastal", None, ((Surface.WALL, "brick_red_running"), (Surface.FLOOR, "oak_ebony")))
    assert floor == both.scene_id
    back = of_json(ask(kitchen, "order", {"of": bricks, "surfaces": {"wall": ""}}))["id"]
    assert back == "galley__coastal"
    drawn = SceneRecipe("galley", "coastal", None, draw_surfaces(5)).scene_id
    assert of_json(ask(kitchen, "order", {"of": "galley__coastal", "random": 5}))["id"] == drawn


def test_the_page_is_loaded_again_after_many_swaps(kitchen: ViewServer) -> None:
    last = "galley__coastal"
    for seed in range(KEPT + 1):
        last = of_json(ask(kitchen, "order", {"of": last, "random": seed}))["id"]
        assert wait_for(kitchen, last)["is_ready"]
    assert ask(kitchen, "model/galley__coastal.glb")[0] == 404
    assert ask(kitchen, "")[0] == 200
    assert wait_for(kitchen, "galley__coastal")["is_ready"]


def test_an_order_that_means_nothing_is_refused(kitchen: ViewServer, monkeypatch: pytest.MonkeyPatch) -> None:
    surfaces = ({"roof": "straw"}, {"wall": "straw"}, 3)
    of_kitchen = [{"style": "baroque"}, *({"surfaces": one} for one in surfaces), {"random": -1}, {"random": "all"}]
    for order in ({}, [], {"of": "nothing"}, *({"of": "galley__coastal", **one} for one in of_kitchen)):
        status, why = ask(kitchen, "order", order)
        assert (status, bool(why)) == (400, True), order
    assert ask(kitchen, "order", {"of": "x"}, Content_Length="many")[0] == 400
    assert ask(kitchen, "order", {"of": "x"}, Content_Length="\xb2")[0] == 400
    monkeypatch.setattr(view_server, "MAX_BODY_BYTES", 20)
    assert ask(kitchen, "order", {"of": "galley__coastal", "style": "rustic"})[0] == 400


def test_of_the_disk_the_report_alone_is_served(kitchen: ViewServer) -> None:
    assert ask(kitchen, "report/galley__coastal/report.html") == (200, b'<p>report <img src="map.png">')
    assert ask(kitchen, "report/galley__coastal/map.png") == (200, b"a picture that it names")
    assert ask(kitchen, "report/galley__coastal/scene.json")[0] == 404
    for path in ("notes.txt", "../secret.html", "..%2Fsecret.html", "link.html", "nothing.html", ""):
        assert ask(kitchen, f"report/galley__coastal/{path}")[0] == 404
    assert ask(kitchen, "report/galley__rustic/report.html")[0] == 404
    assert ask(kitchen, f"report/assets/{viewer_name()}") == (200, viewer_script())  # as report.html names it
    older = "report/assets/viewer_0123456789ab.js"  # as a report of another version names it
    assert ask(kitchen, older) == (200, viewer_script())
    assert ask(kitchen, "report/assets/viewer_0.js")[0] == 404
    assert ask(kitchen, "etc/passwd")[0] == 404


def test_the_command_that_writes_a_kitchen() -> None:
    assert build_command(SceneRecipe("galley", "rustic")) == "casa-assets scenes build galley__rustic"
    new = "casa-assets scenes new galley --style rustic"
    drawn = SceneRecipe("galley", "rustic", 7, draw_surfaces(7), mixed=True, closed=True)
    assert build_command(drawn) == f"{new} --seed 7 --textures random --mixed --closed"
    walls = SceneRecipe("galley", "rustic", None, ((Surface.WALL, "oak"),), objects=9, objects_seed=2)
    assert build_command(walls) == f"{new} --textures wall=oak --objects 9 --objects-seed 2"


def stepped(asset: Asset, state: dict[str, Any], **said: Any) -> dict[str, Any]:
    """The answer to a page that sends the last state back."""
    kept = {name: state[name] for name in ("values", "before", "held_s") if name in state}
    sent = machines.parse_step(json.dumps({**kept, **said}).encode())
    return json.loads(json.dumps(machines.step_machine(asset.behavior, sent)))


def test_time_alone_ends_what_runs_for_a_while() -> None:
    machine = preset("coffee_machine", "espresso_steel")
    on = stepped(machine, stepped(machine, {}), touched=["start_button"], dt_s=0.1)
    assert on["values"]["power"] == "on"
    state = stepped(machine, on, dt_s=0.5)
    assert state["waits"]
    done = stepped(machine, state, dt_s=30.0)
    assert done["values"]["power"] == "off"
    assert not stepped(machine, done, dt_s=0.5)["waits"]


def test_what_is_no_step_or_no_state_of_the_machine_is_refused() -> None:
    for said, what in [
        (b"no json", "no step of a state machine"),
        (b'{"joints": {"a": "far"}}', "joints.a"),
        (b'{"command": "rm"}', "command"),
        (b'{"dt_s": "NaN"}', "dt_s"),
    ]:
        with pytest.raises(CasaError, match=what):
            machines.parse_step(said)
    microwave = preset("microwave", "steel")
    begin = stepped(microwave, {})
    values = ({"power": "melted", "lamp": "off"}, {"power": "on"})
    for wrong in ({"values": values[0]}, {"values": values[1]}, {"held_s": [0.0]}, {"before": [[True]] * 20}):
        with pytest.raises(CasaError):
            stepped(microwave, {**begin, **wrong})


KITCHEN = "one_wall_small__coastal"


def test_an_asset_by_its_folder_its_file_and_its_id_and_alone_in_a_library(boxes: Path, tmp_path: Path) -> None:
    folder = next(Library(boxes / "library").accepted())
    assert find(str(folder), tmp_path, ()) == AssetFolder(folder)
    assert find(str(folder / "model.xml"), tmp_path, ()) == AssetFolder(folder)
    assert find(folder.name, tmp_path, (tmp_path / "none", boxes / "library")) == AssetFolder(folder)
    with pytest.raises(OutputError, match=r"is a library; name one of its assets: .*" + folder.name):
        find(str(boxes / "library"), tmp_path, ())
    shelf = tmp_path / "lib" / "mug"
    shelf.mkdir(parents=True)
    (shelf / "mug_0").symlink_to(folder)
    assert find(str(tmp_path / "lib"), tmp_path, ()) == AssetFolder(shelf / "mug_0")


def test_a_kitchen_by_its_id_its_folder_and_its_file(tmp_path: Path) -> None:
    recipe = SceneRecipe("one_wall_small", "coastal")
    assert find(KITCHEN, tmp_path, ()) == Kitchen(recipe, tmp_path)
    folder, barn = tmp_path / KITCHEN, tmp_path / "barn__baroque"
    for place in (folder, barn):
        place.mkdir()
        (place / "scene.json").write_text("{}", encoding="utf-8")
    (folder / "scene.xml").write_text("<mujoco/>", encoding="utf-8")
    by_path = Kitchen(recipe, tmp_path, is_named_by_path=True)
    assert find(str(folder), Path("elsewhere"), ()) == by_path
    assert find(str(folder / "scene.xml"), Path("elsewhere"), ()) == by_path
    assert by_path.folder == folder
    drawn = SceneRecipe("one_wall_small", "coastal", 7, objects=40, objects_seed=3)
    assert find(f"{KITCHEN}__s7__o40s3", tmp_path, ()) == Kitchen(drawn, tmp_path)
    # A scene of no recipe is left to MuJoCo.
    with pytest.raises(UnknownId, match="barn__baroque"):
        find(str(barn), tmp_path, ())
    (barn / "scene.xml").write_text("<mujoco/>", encoding="utf-8")
    found = find(str(barn), tmp_path, ())
    assert isinstance(found, ModelFile)
    assert (found.path, "barn__baroque" in found.why) == (barn / "scene.xml", True)


def test_a_member_of_a_family_or_of_a_category_and_the_nearest_of_a_name_of_nothing(tmp_path: Path) -> None:
    titles = {
        "microwave": "microwave/",
        "microwave/steel": "microwave/steel",
        "apple": "apple/#0",
        "apple/3": "apple/#3",
    }
    for name, title in titles.items():
        found = find(name, tmp_path, ())
        assert isinstance(found, Member)
        assert found.id.startswith(title)
        assert found.request.is_object == name.startswith("apple")
    nearest_of = {"microwave/steal": "steel", "microwav": "microwave", "aple": "apple", "apple/first": "apple/0"}
    for name, nearest in {**nearest_of, "one_wall_smal__coastal": KITCHEN}.items():
        with pytest.raises(UnknownId, match=nearest):
            find(name, tmp_path, ())


def test_a_path_that_shows_nothing_says_what_to_do(tmp_path: Path) -> None:
    for name in ("mug.glb", "mug.txt", f"scenes/{KITCHEN}/scene.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("{}", encoding="utf-8")
    for name, advice in [
        ("nothing", "no such file"),
        ("mug.glb", r"casa-assets ingest .*mug\.glb"),
        ("mug.txt", "is no MJCF"),
        (".", "holds no asset and no scene"),
        ("scenes", rf"is a folder of scenes; name one of them: {KITCHEN}"),
    ]:
        with pytest.raises(OutputError, match=advice):
            find(str(tmp_path / name), tmp_path, ())


def run(folder: Path) -> list[str]:
    return [event.kind for event in ingest([folder / "in"], Options(folder / "library"))]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`in`, a box of which nobody says what it is, and `library`, made of it."""
    folder = tmp_path_factory.mktemp("review")
    (folder / "in").mkdir()
    (folder / "in" / "<b>qwxz.obj").write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    assert run(folder) == ["review"]
    return folder


@pytest.fixture
def server(folder: Path) -> Iterator[ReviewServer]:
    with running(ReviewServer(Library(folder / "library"))) as server:
        yield server


def test_shows_what_waits_with_its_picture_and_takes_no_markup(server: ReviewServer) -> None:
    status, page = ask(server, f"/{server.token}/")
    assert status == 200
    assert b"up_axis" in page
    assert b"<b>qwxz" not in page
    status, picture = ask(server, f"/{server.token}/0")
    assert (status, picture[:4]) == (200, b"\x89PNG")
    assert ask(server, f"/{server.token}/1")[0] == 404
    assert ask(server, f"/{server.token}/../../library.json")[0] == 404


def test_strangers_and_words_that_mean_nothing_are_refused(server: ReviewServer, folder: Path) -> None:
    (entry,) = server.waiting
    accept = {"sha256": entry.sha256, "decision": "accept"}
    assert ask(server, "/")[0] == 404
    assert ask(server, "/wrong/decide", accept)[0] == 400
    assert ask(server, f"/{server.token}/decide", accept, Host="elsewhere.example")[0] == 400
    for said in ({"category": "no_such_thing"}, {"size_m": "long"}, {"decision": "perhaps"}):
        status, message = ask(server, f"/{server.token}/decide", {"sha256": entry.sha256, **said})
        assert status == 400
        assert b"cannot be understood" in message
    assert ask(server, f"/{server.token}/decide", {"sha256": "abc"})[0] == 400
    assert ask(server, f"/{server.token}/decide", ["no object"])[0] == 400
    assert read_overrides(Library(folder / "library")) == {}


def test_what_is_decided_is_obeyed_by_the_next_run(server: ReviewServer, folder: Path) -> None:
    (entry,) = server.waiting
    address = f"/{server.token}/decide"
    assert ask(server, address, {"sha256": entry.sha256, "decision": "reject"})[0] == 200
    assert run(folder) == ["rejected"]
    (refused,) = entries(Library(folder / "library"))
    assert refused.code == "REV002"
    assert ask(server, address, {"sha256": entry.sha256, "decision": "accept", "mass_kg": "0.4"})[0] == 200
    assert run(folder) == ["accepted"]
    (accepted,) = entries(Library(folder / "library"))
    assert accepted.to_decide == ()
    assert accepted.summary.mass == pytest.approx(0.4)
