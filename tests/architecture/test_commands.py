"""The grammar of the command line: one type for each name of an option, and what every verb has."""

from __future__ import annotations

import re
import shlex
from collections import defaultdict
from collections.abc import Iterator
from types import UnionType
from typing import Any, Union, get_args, get_origin

import typer

from casa_assets.cli.group import Verb
from casa_assets.cli.main import app

# Verbs that name what there is: they have --json, and nothing to be quiet about.
LISTS = {f"{thing} list" for thing in ("scenes", "families", "objects", "textures", "categories")}
LISTS |= {"categories show", "checks", "schemas"}
# Verbs that serve a page or open a window until they are told to stop.
SERVERS = {"review", "view"}
CLI: Any = typer.main.get_command(app)
LANGUAGE = ("--json", "--quiet", "--verbose")


def verbs(command: Any = None, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Every verb that is shown, with its words."""
    command = CLI if command is None else command
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


def main_name(parameter: Any) -> str:
    return next(name for name in parameter.opts if name.startswith("--"))


def test_options_are_of_one_type_say_what_they_do_and_every_verb_has_those_of_all() -> None:
    found: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    bare = []
    for path, command in VERBS.items():
        for option in options(command):
            found[main_name(option)][kind_of(option)].append(path)
            bare += [] if option.help else [f"{path} {main_name(option)}"]
        names = {name for option in options(command) for name in option.opts}
        asked = () if path in SERVERS else LANGUAGE[:1] if path in LISTS else LANGUAGE
        if not isinstance(command, Verb) or not set(asked) <= names:
            bare.append(path)
    assert {name: dict(meanings) for name, meanings in found.items() if len(meanings) > 1} == {}
    assert bare == []


def unknown(words: list[str]) -> list[str]:
    """What of a line after `casa-assets` the program does not have: a verb, or options of the verb."""
    command = CLI
    while hasattr(command, "commands") and words:
        if words[0] not in command.commands:
            return words[:1]
        command, words = command.commands[words[0]], words[1:]
    known = {name for p in command.params for name in (*p.opts, *p.secondary_opts)} | {"--help"}
    return [word for word in words if word.startswith("-") and word.partition("=")[0] not in known]


def test_every_verb_shows_examples_with_options_that_it_has() -> None:
    wrong = []
    for path, command in VERBS.items():
        lines = re.findall(r"^.*?(casa-assets .*)$", command.callback.__doc__ or "", re.MULTILINE)
        examples = [shlex.split(line)[1:] for line in lines if line.startswith(f"casa-assets {path}")]
        wrong += [(path, unknown(words)) for words in examples or [["no example"]] if unknown(words)]
    assert wrong == []
