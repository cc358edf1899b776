"""What a user is told of a slip: one line that says what is wrong and what would be right, and one with the help."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from casa_assets import registry
from casa_assets.cli.main import app
from casa_assets.errors import CasaError, UnknownId
from tests.support.library.libraries import called as casa


def test_wrong_use_is_one_line_and_the_place_of_the_help(
    subtests: pytest.Subtests,
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
        with subtests.test(words=words):
            done = CliRunner().invoke(app, words.split())
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


# Paths below a file that is no folder are refused for root as well.
NO_PLACE = "/dev/null/place"


def test_a_name_like_no_other_is_told_what_there_is() -> None:
    assert str(UnknownId("plan", "zzz", ["galley", "l_small"])) == "unknown plan 'zzz'; there are galley, l_small"
    assert str(UnknownId("plan", "galey", ["galley"])).endswith("did you mean galley?")
    assert str(UnknownId("plan", "zzz", [])).endswith("there are none")
    assert str(UnknownId("plan", "zzz", map(str, range(100, 109)))).endswith("and 3 more")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["textures", "make", "oak_natural_plank", "--out", NO_PLACE, "--width-px", "64"], "cannot be written to"),
        (["families", "show", "microwave", "--preset", "stel", "--out", NO_PLACE], "did you mean steel?"),
        (["report", "--library", "{empty}"], "is no library"),
        (["report", "--library", "{empty}", "--out", "report.json"], "name a file that ends in .html"),
        (["preview", "{file}"], "is no MJCF"),
        (["articulate", "{empty}"], "no mesh found"),
        (["ingest", "{empty}", "--library", "{empty}/library"], "no mesh found in"),
        (["articulate", "{file}", "--up", "sideways"], "--up"),
        (["articulate", "{file}", "--decisions", "{empty}"], "--decisions"),
        (["scenes", "preview", "l_small__coastal", "--out", "{empty}"], "casa-assets scenes build l_small__coastal"),
        (["preview", "{empty}"], "no asset found"),
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
