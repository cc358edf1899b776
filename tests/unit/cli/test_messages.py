"""What a user stumbles over: places that cannot be written to, folders that are none, tables in a narrow window."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest
import typer
from rich.console import Console

from casa_assets import registry
from casa_assets.cli import ingest_output
from casa_assets.cli.main import app
from casa_assets.cli.output import bar, pluralize
from casa_assets.errors import UnknownId
from casa_assets.pipeline.library.library import Summary
from casa_assets.pipeline.reports.entry import NO_CHECKS, Entry
from tests.libraries import called as casa

# Paths below a file that is no folder are refused for root as well.
NO_PLACE = "/dev/null/place"


def test_plurals(subtests: pytest.Subtests) -> None:
    for number, thing, message in [
        (0, "input", "0 inputs"),
        (1, "input", "1 input"),
        (2, "category", "2 categories"),
        (3, "box", "3 boxes"),
    ]:
        with subtests.test(number=number, thing=thing, message=message):
            assert pluralize(number, thing) == message


def test_a_name_like_no_other_is_told_what_there_is() -> None:
    assert str(UnknownId("plan", "zzz", ["galley", "l_small"])) == "unknown plan 'zzz'; there are galley, l_small"
    assert str(UnknownId("plan", "galey", ["galley"])).endswith("did you mean galley?")
    assert str(UnknownId("plan", "zzz", [])).endswith("there are none")
    assert str(UnknownId("plan", "zzz", map(str, range(100, 109)))).endswith("and 3 more")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["textures", "make", "oak_natural_plank", "--out", NO_PLACE, "--width-px", "64"], "cannot be written to"),
        (["textures", "list", "--set", "wal"], "did you mean wall?"),
        (["families", "show", "microwave", "--preset", "stel", "--out", NO_PLACE], "did you mean steel?"),
        (["report", "--library", "{empty}"], "is no library"),
        (["report", "--library", "{empty}", "--out", "report.json"], "name a file that ends in .html"),
        (["find", "mug", "--library", "{empty}"], "is no library"),
        (["preview", "{file}"], "is no MJCF"),
        (["articulate", "{empty}"], "no mesh found"),
        (["articulate", "{file}", "--up", "sideways"], "--up"),
        (["articulate", "{file}", "--decisions", "{empty}"], "--decisions"),
        (["scenes", "preview", "l_small__coastal", "--out", "{empty}"], "casa-assets scenes build l_small__coastal"),
        (["scenes", "new", "galley", "--style", "rustik"], "did you mean rustic"),
        (["preview", "{empty}"], "no asset found"),
        (["categories", "show", "mugg"], "did you mean mug"),
    ],
)
def test_misuse_is_told_in_a_line_and_leaves_nothing(arguments: list[str], message: str, tmp_path: Path) -> None:
    empty, file = tmp_path / "empty", tmp_path / "box.obj"
    empty.mkdir()
    file.write_text("v 0 0 0\n", encoding="ascii")
    done = casa(*(a.format(empty=empty, file=file) for a in arguments))
    assert done.returncode == 2, done.stderr
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert list(empty.iterdir()) == []


def test_a_folder_without_meshes_makes_no_library(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    done = casa("ingest", tmp_path / "empty", "--library", tmp_path / "out" / "library")
    assert done.returncode == 2
    assert "no mesh found in" in done.stderr
    assert done.stdout == ""
    assert not (tmp_path / "out").exists()


def entry(name: str, source: str) -> Entry:
    known = {field.name: "" for field in fields(Entry)}
    summary = Summary(extents=(0.122, 0.0827, 0.0968), mass=0.2922, colliders=21, hull_vertices=54, faces=3068)
    told = {"id": name, "source_path": source, "accepted": True, "summary": summary}
    return Entry(**{**known, "warnings": (), "results": (), "guesses": (), "checks": NO_CHECKS, **told})  # type: ignore[arg-type]


@pytest.mark.parametrize("is_terminal", [True, False], ids=["terminal", "pipe"])
def test_eighty_columns_keep_every_number_and_name(is_terminal: bool) -> None:
    console = Console(width=80, record=True, color_system=None, force_terminal=is_terminal)
    source = "some/rather/long/folder/g_nonmanifold_fin_of_a_mug.glb"
    with console.capture() as taken:
        ingest_output._accepted_table([entry("mug_fb61aea070", source)]).print(console)
    text = taken.get()
    for words in ("mug_fb61aea070", "12.2 x 8.27 x 9.68", "292 g", "shapes", "advice", source):
        assert words in text
    assert not is_terminal or max(map(len, text.splitlines())) <= 80


def test_a_bar_that_nobody_watches_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with bar(Console(force_terminal=False)) as progress:
        progress.advance(progress.add_task("looking", total=1))
    assert capsys.readouterr().out == ""


def test_the_help_of_ingest_shows_the_limits_of_the_registry(subtests: pytest.Subtests) -> None:
    for option, limit, unit in [
        ("timeout", "input_seconds", 1),
        ("memory", "input_memory_bytes", 1e9),
        ("max_size", "input_bytes", 1e6),
        ("max_faces", "input_faces", 1),
        ("max_texture", "input_texture_px", 1),
        ("max_pixels", "input_texture_pixels", 1e6),
    ]:
        with subtests.test(option=option, limit=limit, unit=unit):
            command = typer.main.get_command(app).commands["ingest"]  # type: ignore[attr-defined]
            told = re.search(r"; ([\d.]+) by default\.$", next(p.help for p in command.params if p.name == option))
            assert told
            assert float(told[1]) == registry.load().limits[limit] / unit
