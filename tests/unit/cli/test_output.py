"""Where words go and how: JSON alone on standard output, tables whole at any width, the last line how to look at it."""

from __future__ import annotations

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
from casa_assets.library.library import Library
from casa_assets.registry.families import families, object_names
from casa_assets.show.view.subject import AssetFolder, find
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


def test_words_are_quoted_and_json_and_quiet_say_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    Output().look(Path("out/my library/mug"), "--library", "a'b")
    assert capsys.readouterr() == ("", f"{LINE}'out/my library/mug' --library 'a'\"'\"'b'\n")
    Output().look()
    Output(as_json=True).look("mug")
    Output(quiet=True).look("mug")
    assert capsys.readouterr() == ("", "")


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
