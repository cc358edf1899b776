"""Names of options of the last release: each still works, says what it is called now, and is shown nowhere."""

from __future__ import annotations

from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from casa_assets.cli.verb import renamed, verb
from tests.libraries import casa

OLD = {"--output": "--out", "-o": "--out", "--size": "--width-px", "--anew": "--force"}
app = typer.Typer()


@app.command(cls=verb(OLD))
def draw(
    name: str,
    out: Annotated[str, typer.Option("--out")] = "here",
    width_px: Annotated[int, typer.Option("--width-px")] = 1,
    force: Annotated[bool, typer.Option("--force")] = False,
    verbose: Annotated[bool, typer.Option("--verbose")] = False,
) -> None:
    """Draw a thing."""
    typer.echo(f"{name} {out} {width_px} {force}")


@pytest.mark.parametrize(
    ("words", "printed", "told"),
    [
        (["x", "--output", "there"], "x there 1 False", ["--output is now --out"]),
        (["x", "--output=there"], "x there 1 False", ["--output is now --out"]),
        (["x", "-o", "there", "--size", "64"], "x there 64 False", ["-o is now --out", "--size is now --width-px"]),
        (["-othere", "x"], "x there 1 False", ["-o is now --out"]),
        (["x", "--anew"], "x here 1 True", ["--anew is now --force"]),
        (["--", "--anew"], "--anew here 1 False", []),
        (["x", "--out", "there", "--width-px", "64"], "x there 64 False", []),
    ],
)
def test_an_old_name_works_and_is_told_about(words: list[str], printed: str, told: list[str]) -> None:
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0
    assert result.stdout == f"{printed}\n"
    assert [line.partition(": ")[2].partition(";")[0] for line in result.stderr.splitlines()] == told


def test_old_names_are_not_shown() -> None:
    shown = CliRunner().invoke(app, ["--help"]).stdout
    assert "--out" in shown
    assert not any(old in shown for old in ("--output", "--size", "--anew"))


def test_words_without_old_names_stay_as_they_are() -> None:
    words = ["--out=--output", "-x", "a", "--", "-o"]
    assert renamed(words, OLD) == words


def test_verbose_says_what_a_verb_took() -> None:
    result = CliRunner().invoke(app, ["x", "--verbose"])
    assert "s of processor time" in result.stderr
    assert result.stdout == "x here 1 False\n"


def test_scene_new_is_scenes_new() -> None:
    done = casa("scene", "new", "galley", "--style", "rustik")
    assert (done.returncode, done.stdout) == (2, "")
    assert "`scene new` is now `scenes new`" in done.stderr
    assert "did you mean rustic" in done.stderr
    assert "scene " not in casa("--help").stdout
