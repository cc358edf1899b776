"""The text of --help: whole words and whole examples at any width, options in sections, no types of Python."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterable, Iterator
from typing import Any

import typer

# Sections in which options are shown; those of no section come first, those of all verbs last.
LIMITS, CLUSTER, GENERAL = "Limits", "Cluster", "General"
OPTIONS, ARGUMENTS, COMMANDS = "Options", "Arguments", "Commands"
LAST = (LIMITS, CLUSTER, GENERAL)
INDENT = "  "
NAMES_WIDTH = 30  # of the column of names; the text of a longer one begins on the next line
MOST_CHOICES = 28  # characters of choices that stand beside the name of an option
_NUMBERS = {"int": "N", "float": "X"}


def help_text(command: Any, ctx: Any, width: int) -> str:
    """The help of a command or a group of commands.

    Args:
        width: characters of a line.
    """
    prose, examples = help_parts(command.help or "")
    usage = f"Usage: {ctx.command_path} "
    lines = _wrapped(" ".join(usage_pieces(command, ctx)), width, usage, " " * len("Usage: ") + INDENT)
    for paragraph in prose:
        lines += ["", *_wrapped(paragraph, width, INDENT, INDENT)]
    if examples:
        lines += ["", _heading("Example" if len(examples) == 1 else "Examples")]
        lines += [f"{INDENT}{line}".rstrip() for line in examples]
    for title, rows in (*_command_sections(command, ctx), *_parameter_sections(command, ctx)):
        lines += ["", _heading(title), *_definitions(rows, width)]
    for paragraph in _paragraphs(command.epilog or ""):
        lines += ["", *_wrapped(paragraph, width, INDENT, INDENT)]
    return "\n".join(lines) + "\n"


def help_parts(text: str) -> tuple[list[str], list[str]]:
    """The paragraphs of a docstring, each on one line, and the lines of its examples, which are its last part."""
    lines = inspect.cleandoc(text).split("\n")
    begin = next((n for n, line in enumerate(lines) if line.strip().startswith(("Example:", "Examples:"))), len(lines))
    examples = [line.partition(":")[2] if n == 0 else line for n, line in enumerate(lines[begin:])]
    examples[:1] = [line.strip() for line in examples[:1]]
    rest = textwrap.dedent("\n".join(examples[1:])).split("\n")
    return _paragraphs("\n".join(lines[:begin])), [line for line in (*examples[:1], *rest) if line.strip()]


def usage_pieces(command: Any, ctx: Any) -> list[str]:
    """The words behind the name of a command in its usage: `[OPTIONS]`, then arguments in capitals."""
    arguments = [p for p in command.get_params(ctx) if p.param_type_name == "argument"]
    pieces = [command.options_metavar or "", *(_in_usage(p) for p in arguments)]
    return [piece for piece in (*pieces, getattr(command, "subcommand_metavar", "")) if piece]


def parameter_name(parameter: Any) -> str:
    """An argument in capitals, an option by its long name."""
    if parameter.param_type_name == "argument":
        return str(parameter.metavar or str(parameter.name).upper().strip("_"))
    return str(next((name for name in parameter.opts if name.startswith("--")), parameter.opts[0]))


def value_name(parameter: Any) -> str:
    """What stands for the value of an option, such as `N`, `DIR` or `local|ray`; empty for a flag."""
    if getattr(parameter, "is_flag", False):
        return ""
    if parameter.metavar:
        return str(parameter.metavar)
    kind = getattr(parameter, "type_descriptor", None)
    if kind is None:
        return "VALUE"
    if kind.choices:
        choices = "|".join(str(getattr(choice, "value", choice)) for choice in kind.choices)
        return choices if len(choices) <= MOST_CHOICES else "NAME"
    if kind.is_path or "Path" in str(kind.annotation):
        info = kind.parameter_info
        return "FILE" if not info.dir_okay else "DIR" if not info.file_okay else "PATH"
    number = next((name for word, name in _NUMBERS.items() if word in str(kind.annotation)), "TEXT")
    return " ".join([number] * max(parameter.nargs, 1))


def default_text(parameter: Any) -> str:
    """The default of a parameter as a user would write it; empty where there is none to speak of."""
    shown = getattr(parameter, "show_default", True)
    if isinstance(shown, str):
        return shown
    default = parameter.default() if callable(parameter.default) else parameter.default
    if not shown or default in (None, "", (), [], False):
        return "off" if default is False and parameter.secondary_opts and shown else ""
    return "on" if default is True else str(getattr(default, "value", default))


def _in_usage(parameter: Any) -> str:
    """An argument in the usage: `SOURCES...`, or `[LIBRARY]` where it may be left out."""
    more = "..." if parameter.nargs != 1 else ""
    return f"{parameter_name(parameter)}{more}" if parameter.required else f"[{parameter_name(parameter)}]{more}"


def _option(parameter: Any) -> str:
    """The names of an option with what stands for its value: `-q, --quiet`, `--jobs N`, `--[no-]pictures`."""
    word = parameter_name(parameter).removeprefix("--")
    if parameter.secondary_opts == [f"--no-{word}"]:
        return f"--[no-]{word}"
    names = ", ".join(sorted((*parameter.opts, *parameter.secondary_opts), key=len))
    return f"{names} {value_name(parameter)}".rstrip()


def _parameter_sections(command: Any, ctx: Any) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    sections: dict[str, list[tuple[str, str]]] = {ARGUMENTS: [], OPTIONS: []}
    for parameter in command.get_params(ctx):
        if parameter.hidden:
            continue
        is_argument = parameter.param_type_name == "argument"
        name = parameter_name(parameter) if is_argument else _option(parameter)
        panel = ARGUMENTS if is_argument else getattr(parameter, "rich_help_panel", None) or OPTIONS
        panel = GENERAL if "--help" in parameter.opts else panel
        sections.setdefault(panel, []).append((name, _about(parameter)))
    order = [*(name for name in sections if name not in LAST), *(name for name in LAST if name in sections)]
    yield from ((name, sections[name]) for name in order if sections[name])


def _about(parameter: Any) -> str:
    """The help of a parameter with its default and the range of its values."""
    notes = ["needed"] if parameter.required and parameter.param_type_name == "option" else []
    if default := default_text(parameter):
        notes.append(f"default: {default}")
    low, high = getattr(parameter, "min", None), getattr(parameter, "max", None)
    if low is not None and high is not None:
        notes.append(f"{low:g} to {high:g}")
    words = " ".join((parameter.help or "").split())
    return f"{words} [{'; '.join(notes)}]".strip() if notes else words


def _command_sections(command: Any, ctx: Any) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    sections: dict[str, list[tuple[str, str]]] = {}
    for name in command.list_commands(ctx) if hasattr(command, "list_commands") else ():
        inner = command.get_command(ctx, name)
        if inner is None or inner.hidden:
            continue
        panel = inner.rich_help_panel if isinstance(inner.rich_help_panel, str) else COMMANDS
        about = help_parts(inner.short_help or inner.help or "")[0]
        sections.setdefault(panel, []).append((name, about[0] if about else ""))
    yield from sections.items()


def _definitions(rows: Iterable[tuple[str, str]], width: int) -> list[str]:
    """Names on the left and what is said of each on the right."""
    rows = list(rows)
    column = min(max(len(name) for name, _ in rows), NAMES_WIDTH) + 2 * len(INDENT)
    lines: list[str] = []
    for name, text in rows:
        first = f"{INDENT}{name}"
        if len(first) + len(INDENT) > column:
            lines.append(first)
            first = ""
        lines += _wrapped(text, width, first.ljust(column), " " * column)
    return lines


def _paragraphs(text: str) -> list[str]:
    parts = (" ".join(part.split()) for part in inspect.cleandoc(text).split("\n\n"))
    return [part for part in parts if part]


def _wrapped(text: str, width: int, first: str, rest: str) -> list[str]:
    """The text on lines that end between words, with an indent of the first and of the rest."""
    wrapper = textwrap.TextWrapper(width, break_long_words=False, break_on_hyphens=False)
    wrapper.initial_indent, wrapper.subsequent_indent = first, rest
    return [line.rstrip() for line in wrapper.wrap(text)] or [first.rstrip()]


def _heading(title: str) -> str:
    return typer.style(f"{title}:", bold=True)
