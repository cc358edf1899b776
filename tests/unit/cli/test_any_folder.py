"""Where a user works does not matter: spaces, letters of any script, a leading dash, a very long path.

Everything here is made in one folder whose path has all of these; results are those of a plain folder.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from casa_assets.cli.main import app
from casa_assets.layouts.run import check
from casa_assets.layouts.run.recipe import SceneResult
from casa_assets.library.entry_files import read_certificate
from casa_assets.library.library import Library
from casa_assets.model.issue import Status
from casa_assets.show.view.model import make
from casa_assets.show.view.review import ReviewServer
from casa_assets.show.view.subject import cache_of, find
from tests.support.library.libraries import BOXES, box_obj, differences, entries_of, no_workers
from tests.support.library.server_requests import ask as ask_view
from tests.support.library.server_requests import serving
from tests.unit.articulate.blocks import drawers
from tests.unit.articulate.test_assemble import obj
from tests.unit.conftest import RECIPE, SMALLEST

PLACE = Path("Küche 空 1", "-x", "long " + "a" * 195)
LIBRARY, KITCHENS = "-lib é", "Küchen 1"


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder, which is also the working folder, with a library made of inputs that can only be read."""
    folder = tmp_path_factory.mktemp("any") / PLACE
    inputs = folder / "in put"
    inputs.mkdir(parents=True)
    (inputs / "milk_carton.obj").write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    (inputs / "broken.glb").write_bytes(b"glTF\x02\0\0\0\xff\0\0\0")
    for path in (*inputs.iterdir(), inputs):
        path.chmod(0o555)
    vertices, faces, _ = drawers()
    obj(folder / "-drawers é.obj", vertices, faces)
    with pytest.MonkeyPatch.context() as patch, no_workers():
        patch.chdir(folder)
        patch.setenv("HOME", "/nonexistent")
        run("ingest", "in put", f"--library={LIBRARY}", "--jobs=1", code=1)
        run("families", "build", "switch", "--samples=1", "--no-pictures", f"--library={LIBRARY}", "--jobs=1")
        run("objects", "build", "apple", "--count=1", f"--library={LIBRARY}", "--jobs=1")
        options = ("--up=+z", "--front=-y", "--size-m=0.5", "--review", "--category=object", "--jobs=1")
        run("articulate", f"--library={LIBRARY}", *options, "--", "-drawers é.obj", code=None)
        yield folder
        inputs.chmod(0o755)


def run(*words: str, code: int | None = 0) -> str:
    """Run a command in this process; its output."""
    done = CliRunner().invoke(app, words)
    assert code is None or done.exit_code == code, f"{done.output}{done.exception!r}"
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.output


def test_meshes_become_what_they_become_elsewhere(place: Path, boxes: Path) -> None:
    plain = set(entries_of(boxes / "library")) & set(entries_of(place / LIBRARY))
    assert any(name.startswith("milk_carton/") or "/milk" in name for name in plain), plain
    # What could not be read says where it was looked for.
    same = sorted(name for name in plain if "/unread_" not in name)
    assert same
    assert [name for name in same if differences(boxes / "library" / name, place / LIBRARY / name)] == []
    # Those that are generated or articulated pass.
    made = {path.parent.name: read_certificate(path.parent) for path in place.glob(f"{LIBRARY}/*/*/asset.json")}
    producers = {str(one.producer) for one in made.values()}
    assert {"ingest", "family", "articulate"} <= producers
    assert [name for name, one in made.items() if not one.report.passed] == []


def test_verbs_on_the_library_and_pages(place: Path) -> None:
    run("report", f"--library={LIBRARY}", "--3d")
    run("find", "apple", f"--library={LIBRARY}")
    for form, *more in (("glb", "--jobs=1"), ("urdf", "--jobs=1"), ("robocasa",)):
        run("export", form, f"--out=out of {form}", *more, "--", LIBRARY)
    subject = find(next(place.glob(f"{LIBRARY}/apple/*")).as_posix(), place, ())
    with serving(subject, lambda wanted, tell: make(wanted, cache_of(subject), tell)) as server:
        assert ask_view(server, "")[0] == 200
    with ReviewServer(Library(place / LIBRARY), 0) as review:
        assert review.waiting is not None


@pytest.mark.content("code", "layouts.run", keep=0)
def test_a_kitchen_passes_the_checks_that_it_passes_elsewhere(
    tmp_path: Path, checked_kitchen: tuple[Path, SceneResult], monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / PLACE
    place.mkdir(parents=True)
    monkeypatch.chdir(place)
    monkeypatch.setattr(check, "CHECK_FRAME", SMALLEST)
    monkeypatch.setattr(check, "steps_per_second", lambda model: 4000.0)
    done = check.check_one(RECIPE, place / KITCHENS, drawn=False, in_3d=False)
    elsewhere = checked_kitchen[1].report
    assert done.report is not None, done.message
    timed = {"SCN026", "SCN027"}
    here, there = ({r.code: r.status for r in each.results if r.code not in timed} for each in (done.report, elsewhere))
    assert here == there
    assert Status.FAILED not in {status for code, status in here.items() if code.startswith("SCN")}
    run("scenes", "pack", RECIPE.scene_id, "--usdz", f"--scenes-folder={KITCHENS}", "--out=pa ck.usdz")
    assert (place / "pa ck.usdz").is_file()
