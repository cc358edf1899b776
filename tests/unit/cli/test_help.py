"""Help, reference and completion: whole words and examples, the pages of docs/, the names that the registry has."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import typer

import casa_assets as casa
from casa_assets import registry
from casa_assets.cli import options
from casa_assets.cli.group import help_text
from casa_assets.cli.main import app, narrowed
from casa_assets.cli.reference import command_pages
from casa_assets.registry.families import family_names, object_names
from casa_assets.registry.kitchens import plan_names, style_names
from casa_assets.registry.tables import robot_names
from tests.support.program.documents import ROOT

WIDTH = 78  # of 80 columns, as Typer counts them


def commands(command: Any, path: str) -> Iterator[tuple[str, Any]]:
    """A command or group, and all below it."""
    yield path, command
    for name, inner in getattr(command, "commands", {}).items():
        if not inner.hidden:
            yield from commands(inner, f"{path} {name}")


ALL = dict(commands(typer.main.get_command(app), "casa-assets"))


def cut_of(path: str) -> list[str]:
    """What of the help of a command is too wide, cut off or left out at 80 columns."""
    whole = help_text(ALL[path], typer.Context(ALL[path], info_name=path), WIDTH)
    text = re.sub("\x1b\\[[0-9;]*m", "", whole)
    found = [line for line in text.splitlines() if len(line) > WIDTH]
    found += re.findall(r"\u2026|<(?:list|str|bool|int|float|path|dir|file)\b", text)
    doc = textwrap.dedent(ALL[path].help or "")
    for line in doc.splitlines():
        if (call := re.search(r"(?:^|Example:) +(casa-assets .*)", line)) is not None:
            found += [call[1]] if f"\n  {call[1].rstrip()}\n" not in text else []
    sources = [doc, *(p.help or "" for p in ALL[path].params)]
    return found + sorted({word for source in sources for word in source.split()} - {*text.split(), "Example:"})


def test_80_columns_show_whole_words_and_whole_examples() -> None:
    assert {path: found for path in ALL if (found := cut_of(path))} == {}


def test_a_command_alone_has_the_same_help_as_among_all() -> None:
    """The program makes only the command that it is called with."""
    for path, command in ALL.items():
        words = path.split()[1:]
        alone: Any = typer.main.get_command(narrowed(app, words))
        for word in words:
            alone = alone.commands[word]
        shown = help_text(alone, typer.Context(alone, info_name=path), WIDTH)
        assert shown == help_text(command, typer.Context(command, info_name=path), WIDTH), path


REFERENCE = ROOT / "docs" / "reference"


def test_pages_are_up_to_date() -> None:
    found = [REFERENCE / "commands.md", *REFERENCE.glob("commands/*.md")]
    written = {path.relative_to(REFERENCE).as_posix(): path.read_text(encoding="utf-8") for path in found}
    assert written == command_pages(), "run ./dev docs"


def test_names_to_complete_are_those_of_the_registry() -> None:
    assert options.complete_plans("") == list(plan_names())
    assert options.complete_styles("") == list(style_names())
    assert options.complete_families("") == sorted(family_names())
    assert options.complete_categories("") == sorted(registry.load().categories)
    assert options.complete_objects("") == sorted(object_names())
    assert options.complete_robots("") == sorted(robot_names())


def test_kitchens_and_assets_to_complete_are_also_those_that_are_there(tmp_path: Path, monkeypatch: Any) -> None:
    built, folder = tmp_path / "galley__rustic__s7__t5c1d2e3f", tmp_path / "out" / "library" / "mug" / "mug_0a1b2c3d4e"
    for path in (built / "scene.json", folder / "asset.json"):
        path.parent.mkdir(parents=True)
        path.write_text("{}", encoding="utf-8")
    of_folder: Any = SimpleNamespace(params={"out": tmp_path}, args=[])
    assert options.complete_kitchens(of_folder, "galley__r") == ["galley__rustic", built.name]
    assert len(options.complete_kitchens(of_folder, "")) == len(plan_names()) * len(style_names()) + 1
    monkeypatch.chdir(tmp_path)
    assert options.complete_assets("out/library/mug/m") == [f"out/library/mug/{folder.name}{end}" for end in ("", "/")]


def complete(*words: str) -> list[str]:
    """What a shell is offered behind some words, the last of which is begun."""
    environment = {**os.environ, "_CASA_ASSETS_COMPLETE": "complete_bash", "COMP_CWORD": str(len(words))}
    environment["COMP_WORDS"] = " ".join(["casa-assets", *words])
    code = "import sys; sys.argv = ['casa-assets']; from casa_assets.cli.main import app; app(prog_name='casa-assets')"
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    return done.stdout.split()


def test_a_shell_is_offered_names() -> None:
    assert "l_small__coastal" in complete("scenes", "build", "l_small__c")
    assert complete("scenes", "new", "galley", "--style", "rust") == ["rustic"]
    assert complete("families", "show", "microwave", "--preset", "ste") == ["steel"]
    assert complete("categories", "show", "mug") == ["mug"]
    assert complete("textures", "make", "brick_red_r") == ["brick_red_running"]


def test_the_package_runs_as_the_command() -> None:
    told = subprocess.check_output([sys.executable, "-m", "casa_assets", "--version"], text=True)
    assert told == f"casa-assets {casa.__version__}\n"
