"""The last line of each command that makes something: how to look at it."""

from __future__ import annotations

import json
import shlex
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest
import typer

from casa_assets.cli import batch_output as build_output
from casa_assets.cli.output import Output
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult
from casa_assets.library.library import Library
from casa_assets.show.view.subject import AssetFolder, Kitchen, find
from tests.support.library.libraries import called as casa

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


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("ingest", "box", "--library", "lib"), 0),
        (("families", "build", "switch", "--samples", "1", "--no-pictures", "--library", "lib"), 0),
    ],
    ids=lambda value: value[0] + value[1] if isinstance(value, tuple) else "",
)
def test_assets(arguments: Sequence[str], code: int, boxes: Path, tmp_path: Path) -> None:
    places = {"box": str(boxes / "in" / "milk_carton.obj"), "lib": str(tmp_path / "lib")}
    words = [places.get(word, word) for word in arguments]
    run = casa(*words)
    assert run.returncode == code, run.stderr
    (folder,) = named(run)
    assert isinstance(find(folder, tmp_path, ()), AssetFolder)
    again = casa(*words, "--json")
    assert LINE not in again.stdout + again.stderr
    assert all(json.loads(line) for line in again.stdout.splitlines())


def test_of_kitchens_the_first_that_was_made(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    recipe = SceneRecipe("galley", "rustic")
    folder = tmp_path / recipe.scene_id
    folder.mkdir()
    (folder / "scene.json").write_text("{}", encoding="utf-8")
    failed, made = SceneResult(SceneRecipe("galley", "coastal"), message="no room"), SceneResult(recipe, str(folder))
    with pytest.raises(typer.Exit):
        build_output.end([failed, made], Output())
    out, err = capsys.readouterr()
    assert (out, err) == ("", f"{LINE}{folder}\n")
    assert find(str(folder), tmp_path, ()) == Kitchen(recipe, tmp_path, is_named_by_path=True)


def test_an_export_names_where_it_came_from(boxes: Path, tmp_path: Path) -> None:
    library = boxes / "library"
    run = casa("export", "urdf", library, "--out", tmp_path / "urdf")
    assert run.returncode == 0, run.stderr
    asset_id, option, place = named(run)
    assert (option, place) == ("--library", str(library))
    assert isinstance(find(asset_id, tmp_path, (Path(place),)), AssetFolder)
    folder = next(Library(library).accepted())
    assert named(casa("export", "urdf", folder, "--out", tmp_path / "one")) == [str(folder)]
