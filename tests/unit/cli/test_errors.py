"""What a user is told of a slip: one line that says what is wrong and what would be right, and one with the help."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from casa_assets.cli.main import app
from casa_assets.errors import CasaError


def test_wrong_use_is_one_line_and_the_place_of_the_help(
    subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory
) -> None:
    for words, told in [
        ("scenes new l_small --seed -3", "--seed: -3 is less than 0"),
        ("preview . --width-px 5000", "--width-px: 5000 is not from 64 to 4096"),
        ("scenes sample many", "COUNT: 'many' is no whole number"),
        ("scenes fit u_small --width wide --depth 2", "--width: 'wide' is no number"),
        ("textures list --set walls", "--set: 'walls' is none of wall, floor, counter, cabinet; did you mean wall?"),
        ("scenes new", "PLAN is missing"),
        ("ingest nowhere", "SOURCES: path 'nowhere' does not exist"),
        ("report --library nowhere", "--library: folder 'nowhere' does not exist"),
        ("report --libary x", "no such option: --libary; did you mean --library?"),
        ("ingst", "no such command 'ingst'; did you mean ingest"),
        ("schemas scene plan", "too many words: plan"),
        ("scenes pack l_small__coastal", "give one of --zip and --usdz"),
        ("ingest . --engine local --address auto", "--address: is of a Ray cluster; add --engine ray"),
    ]:
        with subtests.test(words=words, told=told):
            tmp_path = tmp_path_factory.mktemp("case")
            file = tmp_path / "plan.yaml"
            file.touch()
            arguments = [word.format(file=file) for word in words.split()]
            done = CliRunner().invoke(app, arguments)
            assert (done.exit_code, done.stdout) == (2, "")
            first, second = done.stderr.splitlines()
            assert first.startswith(f"error: {told}")
            assert second.startswith("hint: casa-assets ")
            assert second.endswith(" --help")


def test_an_unknown_name_is_told_with_those_that_are_near(subtests: pytest.Subtests) -> None:
    for words, told in [
        ("checks SCN999", "unknown code 'SCN999'; did you mean SCN"),
        ("view nothing", "unknown kitchen, asset or file 'nothing'; `casa-assets scenes list` and `casa-assets find`"),
        ("scenes new l_small --textures wall=brik", "unknown wall texture 'brik'; did you mean brick_"),
    ]:
        with subtests.test(words=words, told=told):
            error = CliRunner().invoke(app, words.split()).exception
            assert isinstance(error, CasaError)
            assert str(error).startswith(told)


def test_codes_of_reports_are_explained() -> None:
    done = CliRunner().invoke(app, ["checks", "usd002", "FLT005", "TEX001", "PCK010"])
    assert done.exit_code == 0, done.output
    first = [line for line in done.stdout.splitlines() if not line.startswith(" ")]
    assert [line.split()[0] for line in first] == ["USD002", "FLT005", "TEX001", "PCK010"]
    for words in ("SimReady profile", "error: what fails is kept out", "rejection: the input was not taken", "limit:"):
        assert words in done.stdout
