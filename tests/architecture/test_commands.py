"""The grammar of the command line: one meaning for each name of an option, and what every verb has and says."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from types import UnionType
from typing import Any, Union, get_args, get_origin

import pytest
import typer

from casa_assets.cli.main import app
from casa_assets.cli.verb import Verb

# Verbs that name what there is: they have --json, and nothing to be quiet about.
LISTS = {
    "scenes list", "families list", "objects list", "textures list", "categories list", "categories show", "checks",
    "schemas",
}  # fmt: skip
# Verbs that serve a page or open a window until they are told to stop.
SERVERS = {"review", "view"}
LANGUAGE = ("--json", "--quiet", "--verbose")


def verbs(command: Any = None, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Every verb that is shown, with its words."""
    command = typer.main.get_command(app) if command is None else command
    for name, one in getattr(command, "commands", {}).items():
        if not one.hidden:
            yield from verbs(one, (*path, name))
    if not hasattr(command, "commands"):
        yield " ".join(path), command


VERBS = dict(verbs())


def options(command: Any) -> Iterator[Any]:
    return (p for p in command.params if p.param_type_name == "option")


def kind_of(parameter: Any) -> str:
    """Type of an option as one string, the same whether it may be left out or not."""
    annotation = parameter.type_descriptor.annotation if hasattr(parameter, "type_descriptor") else parameter.type
    if get_origin(annotation) in (Union, UnionType):
        annotation = next(one for one in get_args(annotation) if one is not type(None))
    name = getattr(annotation, "__name__", str(annotation))
    return f"{'list of ' if parameter.multiple else 'flag ' if parameter.is_flag else ''}{name} x {parameter.nargs}"


def words_of(parameter: Any) -> str:
    """The words of help that all verbs share: those before a semicolon."""
    return str(parameter.help).partition(";")[0].rstrip(".")


def main_name(parameter: Any) -> str:
    return next(name for name in parameter.opts if name.startswith("--"))


@pytest.mark.parametrize("meaning", [kind_of, words_of], ids=["type", "words"])
def test_an_option_means_the_same_everywhere(meaning: Any) -> None:
    found: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for path, command in VERBS.items():
        for option in options(command):
            found[main_name(option)][meaning(option)].append(path)
    assert {name: dict(meanings) for name, meanings in found.items() if len(meanings) > 1} == {}


def test_an_option_has_one_long_name() -> None:
    several = [
        (path, option.opts)
        for path, command in VERBS.items()
        for option in options(command)
        if sum(name.startswith("--") for name in option.opts) > 1
    ]
    assert several == []


def test_libraries_are_written_to_library_and_all_else_to_out() -> None:
    for path in ("ingest", "articulate", "families build", "objects build", "textures ingest", "library merge"):
        names = {name for option in options(VERBS[path]) for name in option.opts}
        assert "--library" in names, path
        assert "--out" not in names, path


def test_every_option_says_what_it_does() -> None:
    bare = [f"{path} {main_name(o)}" for path, command in VERBS.items() for o in options(command) if not o.help]
    assert bare == []


@pytest.mark.parametrize("path", sorted(VERBS.keys() - SERVERS))
def test_a_verb_speaks_json_and_can_be_quiet(path: str) -> None:
    names = {name for option in options(VERBS[path]) for name in option.opts}
    assert set(LANGUAGE[:1] if path in LISTS else LANGUAGE) <= names


@pytest.mark.parametrize("path", sorted(VERBS))
def test_a_verb_shows_an_example_and_states_its_exit_codes(path: str) -> None:
    text = VERBS[path].callback.__doc__ or ""
    assert f"casa-assets {path}" in text, "no example"
    if path not in LISTS:
        assert re.search(r"Exit\s+0\s", text), "no exit codes"
        assert re.search(r"\b2\s+(on|when)\b", text), "no word about misuse"


@pytest.mark.parametrize("path", sorted(VERBS))
def test_a_verb_has_the_options_of_all(path: str) -> None:
    assert isinstance(VERBS[path], Verb)


def test_verbs_stand_in_groups() -> None:
    root = typer.main.get_command(app)
    shown = {name: one.rich_help_panel for name, one in root.commands.items() if not one.hidden}  # type: ignore[attr-defined]
    assert {panel for panel in shown.values() if isinstance(panel, str)} == {
        "Make",
        "Look",
        "Check and decide",
        "Export",
    }
    assert [name for name, panel in shown.items() if not isinstance(panel, str)] == []


def test_the_command_line_starts_without_what_makes_assets() -> None:
    code = (
        "import sys; import casa_assets.cli.main;"
        "print(sorted({'numpy', 'pydantic', 'yaml', 'scipy', 'mujoco', 'PIL', 'pxr'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
