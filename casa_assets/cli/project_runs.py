"""Turn the `runs` of a project into words of the command line, and check them before any is called."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from casa_assets.model.registry.document import expected_one_of

if TYPE_CHECKING:
    from casa_assets.model.registry.document import Document, KeyPath
    from casa_assets.model.registry.rows import Project

# Options that hold for all runs, and are given to `make`.
OF_ALL = ("project", "plugins")
# Verbs that serve a page or write a project are no part of making a registry.
LEFT_OUT = ("make", "init", "view", "review")


@dataclass(frozen=True)
class Step:
    """A command with its values: the words behind `casa-assets`. takes_json: whether it has an option --json."""

    words: tuple[str, ...]
    takes_json: bool


def steps_of(project: Project, document: Document, group: Any) -> tuple[Step, ...]:
    """The commands of a project in their order.

    Args:
        group: the command of commands, of `typer.main.get_command`.
    Raises:
        RegistryError: with file and line, if a command, an argument or an option does not exist, or has no such value.
    """
    known = dict(_commands(group))
    found = []
    for number, run in enumerate(project.runs):
        ((name, values),) = run.items()
        at: KeyPath = ("runs", number, name)
        if name not in known:
            raise document.fault(at, expected_one_of(tuple(known), name), repr(name))
        words = _words(known[name], values or {}, document, at)
        names = {option for parameter in known[name].params for option in parameter.opts}
        found.append(Step((*name.split(), *words), "--json" in names))
    return tuple(found)


def _commands(group: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    for name, command in group.commands.items():
        if command.hidden or (not before and name in LEFT_OUT):
            continue
        if hasattr(command, "commands"):
            yield from _commands(command, f"{before}{name} ")
        else:
            yield f"{before}{name}", command


def _words(command: Any, values: Mapping[str, Any], document: Document, at: KeyPath) -> Iterator[str]:
    """Options, then the arguments behind them."""
    own = [p for p in command.params if not p.hidden and p.name not in OF_ALL]
    parameters = {name: p for p in own for name in _names(p)}
    behind: list[str] = []
    for key, value in values.items():
        here = (*at, key)
        parameter = parameters.get(key.replace("_", "-"))
        if parameter is None:
            shown = tuple(dict.fromkeys(_names(p)[0] for p in parameters.values()))
            raise document.fault(here, expected_one_of(shown, key), repr(key))
        texts = [_text(one, document, here) for one in value] if isinstance(value, list) else None
        if texts is not None and not (parameter.multiple or parameter.nargs != 1):
            raise document.fault(here, "one value", repr(value))
        if parameter.param_type_name == "argument":
            behind += texts if texts is not None else [_text(value, document, here)]
        elif parameter.is_flag:
            yield from _flag(parameter, value, document, here)
        elif parameter.nargs > 1:
            if texts is None or len(texts) != parameter.nargs:
                raise document.fault(here, f"{parameter.nargs} values", repr(value))
            yield from (_long(parameter.opts), *texts)
        else:
            for text in texts if texts is not None else [_text(value, document, here)]:
                yield f"{_long(parameter.opts)}={text}"
    if behind:
        yield from ("--", *behind)


def _names(parameter: Any) -> list[str]:
    """Names that a parameter has in a project: an argument by its name, an option by each of its long names."""
    if parameter.param_type_name == "argument":
        return [str(parameter.name).rstrip("_").replace("_", "-")]
    return [name.removeprefix("--") for name in parameter.opts if name.startswith("--")]


def _long(names: list[str]) -> str:
    return next(name for name in names if name.startswith("--"))


def _flag(parameter: Any, value: Any, document: Document, at: KeyPath) -> Iterator[str]:
    if not isinstance(value, bool):
        raise document.fault(at, "true or false", repr(value))
    if value:
        yield _long(parameter.opts)
    elif parameter.secondary_opts:
        yield _long(parameter.secondary_opts)


def _text(value: Any, document: Document, at: KeyPath) -> str:
    if isinstance(value, bool | list | dict) or value is None:
        raise document.fault(at, "a text or a number", repr(value))
    return str(value)
