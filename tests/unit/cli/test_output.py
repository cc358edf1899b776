"""Where words go: JSON alone on standard output, nothing but failures where a verb is to be quiet."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from casa_assets import registry
from casa_assets.cli.main import app
from casa_assets.cli.output import Output, measures
from casa_assets.pipeline.library.library import Summary
from casa_assets.registry.families import families
from casa_assets.registry.objects import object_names


def printed(capsys: pytest.CaptureFixture[str], as_json: bool = False, quiet: bool = False) -> tuple[str, str]:
    output = Output(as_json, quiet, verbose=not quiet)
    output.row({"id": "mug", "verdict": "passed"})
    output.line("a [bold]line")
    output.detail("a detail")
    output.wrong("it failed")
    output.error("no result")
    taken = capsys.readouterr()
    return taken.out, taken.err


def test_words_go_to_standard_output_and_errors_do_not(capsys: pytest.CaptureFixture[str]) -> None:
    assert printed(capsys) == ("a [bold]line\na detail\nit failed\n", "no result\n")


def test_json_has_standard_output_for_itself(capsys: pytest.CaptureFixture[str]) -> None:
    out, err = printed(capsys, as_json=True)
    assert json.loads(out) == {"id": "mug", "verdict": "passed"}
    assert err == "a [bold]line\na detail\nit failed\nno result\n"


@pytest.mark.parametrize("as_json", [True, False])
def test_quiet_tells_what_failed_alone(as_json: bool, capsys: pytest.CaptureFixture[str]) -> None:
    out, err = printed(capsys, as_json, quiet=True)
    assert bool(out) == as_json
    assert err == "it failed\nno result\n"


def test_a_detail_is_for_those_who_ask(capsys: pytest.CaptureFixture[str]) -> None:
    Output().detail("a detail")
    assert capsys.readouterr().out == ""


def test_measures_are_kilograms_and_metres() -> None:
    summary = Summary(extents=(0.1, 0.2, 0.3), mass=0.4, colliders=1, hull_vertices=8, faces=12)
    assert measures(summary) == {"mass": 0.4, "size": [0.1, 0.2, 0.3]}
    assert measures(None) == {"mass": None, "size": None}


def rows(*words: str) -> list[dict[str, object]]:
    result = CliRunner().invoke(app, [*words, "--json"])
    assert result.exit_code == 0, result.output
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_lists_print_an_object_for_each_thing(subtests: pytest.Subtests) -> None:
    for words in ["scenes list", "families list", "objects list", "textures list", "categories list", "checks"]:
        with subtests.test(words=words):
            found = rows(*words.split())
            assert len(found) > 10
            assert all(isinstance(row["id"], str) and row["id"] for row in found)


def test_a_made_thing_has_folder_mass_size_and_verdict(tmp_path: Path) -> None:
    words = ["families", "show", "vase", "--samples", "1", "--no-check", "--width-px", "64", "--out", str(tmp_path)]
    (row,) = rows(*words)
    assert row["verdict"] == "passed"
    assert (Path(str(row["folder"])) / "model.xml").is_file()
    assert isinstance(row["mass"], float)
    assert isinstance(row["size"], list)
    assert len(row["size"]) == 3
    again = CliRunner().invoke(app, [*words, "--quiet"])
    assert (again.exit_code, again.stdout, again.stderr) == (0, "", "")


def test_categories_say_size_mass_and_what_builds_them() -> None:
    mug, microwave = rows("categories", "show", "mug", "microwave")
    assert mug["class"] == "drinkware"
    assert mug["looks_like"] == ["coffee_cup"]
    assert mug["built_by"] == ["objects build mug"]
    assert microwave["built_by"] == ["families build microwave"]
    known = registry.load()
    assert mug["mass"] == known.categories["mug"].mass_kg.typical
    assert mug["size"] == [side.typical for side in known.categories["mug"].extents]
    text = CliRunner().invoke(app, ["categories", "show", "mug"]).stdout
    assert "casa-assets objects build mug" in text
    assert "0.25 to 0.5 kg" in text


def test_every_category_and_what_builds_it_is_listed() -> None:
    found = {str(row["id"]): row for row in rows("categories", "list")}
    known = registry.load()
    assert found.keys() == {*known.categories, *known.fixtures}
    built = [command for row in found.values() for command in row["built_by"]]  # type: ignore[attr-defined]
    assert set(built) == {
        *(f"families build {name}" for name in families()),
        *(f"objects build {name}" for name in object_names()),
    }
