"""The page of review: what it shows, what it writes, and who it answers."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from casa_assets.ingest.run.run import Options, ingest
from casa_assets.library.entry import entries
from casa_assets.library.library import Library
from casa_assets.library.review import read_overrides
from casa_assets.show.view.review import ReviewServer
from tests.support.library.libraries import BOXES, box_obj
from tests.support.library.server_requests import ask

pytestmark = pytest.mark.content("code", "show.view", keep=0)


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
    with ReviewServer(Library(folder / "library")) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server
        server.shutdown()
        thread.join()


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
    assert accepted.summary is not None
    assert accepted.summary.mass == pytest.approx(0.4)
