"""Where words go and how: JSON, tables, the last line; one line about a slip, with what would be right and the help."""

from __future__ import annotations

import importlib.util
import json
import shlex
import subprocess
from pathlib import Path

import pytest
from rich.console import Console
from rich.text import Text
from typer.testing import CliRunner

from casa_assets import registry
from casa_assets.cli.main import app
from casa_assets.cli.output import Output, TextTable
from casa_assets.errors import CasaError
from casa_assets.library.library import Library
from casa_assets.registry.families import families, object_names
from casa_assets.show.view.subject import AssetFolder, find
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import called as casa


def test_json_has_standard_output_for_itself_and_quiet_shows_what_failed(capsys: pytest.CaptureFixture[str]) -> None:
    said = "a [bold]line\na detail\nit failed\n"
    for as_json, quiet, expected in (
        (False, False, (said, "no result\n")),
        (True, False, ('{"id": "mug"}\n', f"{said}no result\n")),
        (False, True, ("", "it failed\nno result\n")),
        (True, True, ('{"id": "mug"}\n', "it failed\nno result\n")),
    ):
        output = Output(as_json, quiet, verbose=not quiet)
        output.row({"id": "mug"})
        output.line("a [bold]line")
        output.detail("a detail")
        output.wrong("it failed")
        output.error("no result")
        assert capsys.readouterr() == expected
    Output().look(Path("out/my library/mug"), "--library", "a'b")
    assert capsys.readouterr() == ("", f"{LINE}'out/my library/mug' --library 'a'\"'\"'b'\n")
    Output().look()
    Output(as_json=True).look("mug")
    Output(quiet=True).look("mug")
    assert capsys.readouterr() == ("", "")


def test_every_category_and_what_builds_it_is_listed() -> None:
    lines = CliRunner().invoke(app, ["categories", "list", "--json"]).stdout.splitlines()
    found = {row["id"]: row for row in map(json.loads, lines)}
    known = registry.load()
    assert found.keys() == {*known.categories, *known.fixtures}
    assert found["mug"]["class"] == "drinkware"
    assert found["mug"]["looks_like"] == ["coffee_cup"]
    assert found["mug"]["mass"] == known.categories["mug"].mass_kg.typical
    assert found["mug"]["size"] == [side.typical for side in known.categories["mug"].extents]
    built = {command for row in found.values() for command in row["built_by"]}
    assert built == {f"families build {name}" for name in families()} | {
        f"objects build {name}" for name in object_names()
    }


ID, PATH = "mug_fb61aea070", "some/rather/long/folder/g_nonmanifold_fin_of_a_mug.glb"
SENTENCE = "the bounding box is larger than that of any mug, so that the unit of the file may be another one"


def printed(width: int, is_terminal: bool, sentence: str = SENTENCE) -> list[str]:
    console = Console(width=width, force_terminal=is_terminal, color_system=None, force_interactive=False)
    table = TextTable(("asset", "mass", "why", "source"), sentences=("why",), right=("mass",), title="In review")
    table.add(ID, "292 g", sentence, PATH)
    table.add(Text("b", style="red"), "1.2 kg", "", "[b].glb")
    with console.capture() as taken:
        table.print(console)
    return taken.get().splitlines()


def test_names_are_whole_at_every_width_and_a_pipe_gets_one_line_for_each_row() -> None:
    for width in (20, 40, 60, 80, 100, 140, 200):
        lines = printed(width, is_terminal=True)
        text = "\n".join(lines)
        assert [word for word in (ID, "292 g", PATH, "[b].glb", *SENTENCE.split()) if word not in text] == [], width
        assert "…" not in text
        assert not [line for line in lines if len(line.strip()) == 1 and line.strip() != "b"]
        title, heads, _, first, second = printed(width, is_terminal=False)
        assert title == "In review"
        assert heads.split() == ["asset", "mass", "why", "source"]
        assert first.split()[0] == ID
        assert first.endswith(PATH)
        assert SENTENCE in first
        assert second.split() == ["b", "1.2", "kg", "[b].glb"]


LINE = "Look at it: casa-assets view "


def named(run: subprocess.CompletedProcess[str]) -> list[str]:
    """What the last line on standard error says that can be viewed; standard output says nothing of it."""
    assert LINE not in run.stdout
    last = run.stderr.splitlines()[-1]
    assert last.startswith(LINE), run.stderr
    return shlex.split(last.removeprefix(LINE))


def test_the_first_asset_that_is_made_can_be_looked_at(boxes: Path, tmp_path: Path) -> None:
    words = ("ingest", boxes / "in" / "milk_carton.obj", "--library", tmp_path / "lib")
    run = casa(*words)
    assert run.returncode == 0, run.stderr
    (folder,) = named(run)
    assert isinstance(find(folder, tmp_path, ()), AssetFolder)
    again = casa(*words, "--json")
    assert LINE not in again.stdout + again.stderr
    assert all(json.loads(line) for line in again.stdout.splitlines())


def test_an_export_names_where_it_came_from(boxes: Path, tmp_path: Path) -> None:
    library = boxes / "library"
    run = casa("export", "urdf", library, "--out", tmp_path / "urdf")
    assert run.returncode == 0, run.stderr
    asset_id, option, place = named(run)
    assert (option, place) == ("--library", str(library))
    assert isinstance(find(asset_id, tmp_path, (Path(place),)), AssetFolder)
    folder = next(Library(library).accepted())
    assert named(casa("export", "urdf", folder, "--out", tmp_path / "one")) == [str(folder)]


def test_wrong_use_is_one_line_and_the_place_of_the_help() -> None:
    for words, message in [
        ("scenes new l_small --seed -3", "--seed: -3 is less than 0"),
        ("preview . --width-px 5000", "--width-px: 5000 is not from 64 to 4096"),
        ("scenes sample many", "COUNT: 'many' is no whole number"),
        ("scenes fit u_small --width wide --depth 2", "--width: 'wide' is no number"),
        ("textures list --set walls", "--set: 'walls' is none of wall, floor, counter, cabinet; did you mean wall?"),
        ("textures ingest . --tile -1 1 --library /dev/null/x", "--tile: "),
        ("scenes new", "PLAN is missing"),
        ("ingest", "SOURCES is missing"),
        ("fetch", "name uids, or an --lvis category"),
        ("ingest nowhere", "SOURCES: path 'nowhere' does not exist"),
        ("ingest . --library s3://bucket/library", "--library: s3:// is the address of a store"),
        ("ingest . --store /dev/null/store --dry-run", "--store: does not go with --dry-run"),
        ("report --libary x", "no such option: --libary; did you mean --library?"),
        ("ingst", "no such command 'ingst'; did you mean ingest"),
        ("schemas scene plan", "too many words: plan"),
        ("ingest . --engine local --address auto", "--address: is of a Ray cluster; add --engine ray"),
        ("find --library .", "QUERY: there are no words to look for"),
    ]:
        done = CliRunner().invoke(app, words.split())
        assert (done.exit_code, done.stdout) == (2, ""), words
        first, second = done.stderr.splitlines()
        assert first.startswith(f"error: {message}")
        assert second.startswith("hint: casa-assets ")
        assert second.endswith(" --help")
    for words, message in [
        ("checks SCN999", "unknown code 'SCN999'; did you mean SCN"),
        ("view nothing", "unknown kitchen, asset or file 'nothing'; `casa-assets scenes list` and `casa-assets find`"),
        ("scenes new l_small --textures wall=brik", "unknown wall texture 'brik'; did you mean brick_"),
    ]:
        error = CliRunner().invoke(app, words.split()).exception
        assert isinstance(error, CasaError), words
        assert str(error).startswith(message)


def test_codes_of_reports_are_explained() -> None:
    done = CliRunner().invoke(app, ["checks", "usd002", "FLT005", "TEX001", "PCK010"])
    assert done.exit_code == 0, done.output
    first = [line for line in done.stdout.splitlines() if not line.startswith(" ")]
    assert [line.split()[0] for line in first] == ["USD002", "FLT005", "TEX001", "PCK010"]
    for words in ("SimReady profile", "error: what fails is kept out", "rejection: the input was not taken", "limit:"):
        assert words in done.stdout


NO_PLACE = "/dev/null/place"  # a path below a file that is no folder is refused for root as well


@pytest.fixture
def places(tmp_path: Path) -> dict[str, Path]:
    """Small inputs by the words that stand for them; nothing may appear in `empty` or `new`."""
    found = {name: tmp_path / name for name in ("empty", "taken", "new")} | {"file": tmp_path / "box.obj"}
    for name in ("empty", "taken"):
        found[name].mkdir()
    (found["taken"] / "a").touch()
    found["file"].write_text("v 0 0 0\n", encoding="ascii")
    found["mjcf"] = tmp_path / "robot.xml"
    found["mjcf"].write_text("<mujoco><worldbody/></mujoco>", encoding="utf-8")
    return {**found, "library": keep(tmp_path / "library", loose_and_fixed())}


def test_misuse_is_one_line_and_leaves_nothing(places: dict[str, Path]) -> None:
    for words, message in (
        (f"textures make oak_natural_plank --out {NO_PLACE} --width-px 64", "cannot be written to"),
        (f"families show microwave --preset stel --out {NO_PLACE}", "did you mean steel?"),
        ("report --library {empty}", "is no library"),
        ("report --library {empty} --out report.json", "name a file that ends in .html"),
        ("preview {file}", "is no MJCF"),
        ("preview {empty}", "no asset found"),
        ("view {mjcf} --web", "leave --web out"),
        ("articulate {empty}", "no mesh found"),
        ("articulate {file} --up sideways", "--up"),
        ("articulate {file} --decisions {empty}", "--decisions"),
        ("scenes preview l_small__coastal --out {empty}", "casa-assets scenes build l_small__coastal"),
        (f"ingest {{file}} --library {NO_PLACE}", "cannot be written to"),
        ("find mug --library {library} --clip-weights nowhere.pt", "nowhere.pt: there are no weights of CLIP"),
        ("find mug --library {library} --clip-weights x --where size<3", "leave --clip-weights out"),
        ("find mug --library {empty}", "is no library"),
        ("export robocasa {empty} --out {new}", "holds no accepted asset"),
        ("export robocasa {library} --out {taken}", "neither empty nor an earlier export"),
        ("export robocasa {library} --out {new} --registry No", "no name of a registry"),
        ("export urdf --scenes l_smal__coastal --out {new}", "l_small__coastal"),
        ("export urdf {empty} --jobs 2 --out {new}", "holds no accepted asset"),
        ("library push {library} https://someone:secret@example.org/lib", "https://example.org/lib: is no store"),
        ("library push {library} simplecache::s3://bucket/lib", "is no store that can be written to"),
    ):
        done = casa(*(word.format(**places) for word in words.split()))
        assert done.returncode == 2, done.stderr
        assert message in " ".join(done.stderr.split()), words
        assert not any(word in done.stderr for word in ("Traceback", "secret"))
        assert list(places["empty"].iterdir()) == []
        assert not (places["new"] / "assets").exists()


def test_what_is_optional_and_missing_is_named_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "library" / ".casa").mkdir(parents=True)
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pyarrow" else find_spec(name))
    words = ["library", "index", str(tmp_path / "library"), "--out", str(tmp_path / "tables")]
    error = CliRunner().invoke(app, words).exception
    assert isinstance(error, CasaError)
    assert all(word in str(error) for word in ("extra 'parquet'", "-m pip install"))
    assert not (tmp_path / "tables").exists()
