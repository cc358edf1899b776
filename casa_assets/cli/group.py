"""The class of a group of commands: its help, and one form for all errors of use."""

from __future__ import annotations

import difflib
import os
import re
import sys
from collections.abc import Sequence
from functools import partial
from typing import Any

import typer
from rich.console import Console
from rich.text import Text
from typer.core import TyperGroup

from casa_assets.cli.help import help_text, parameter_name, usage_pieces
from casa_assets.cli.text import terminal_safe

NAME = "casa-assets"  # of the program, however it was started
# What Typer raises for any wrong use: it exports one class of these alone.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]
_EXTRA = re.compile(r"Got unexpected extra argument(?:s|\(s\))? \((.*)\)")
_SUGGESTED = re.compile(r"\. Did you mean (.*)\?")


class Group(TyperGroup):
    """Commands under a common word."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        formatter.write(help_text(self, ctx, formatter.width))

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The words behind the name in the usage."""
        return usage_pieces(self, ctx)

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Call the command that is named; where it was called wrongly, say so in our form and end with exit code 2."""
        run = partial(super().main, args, prog_name or NAME, complete_var, False, windows_expand_args, **extra)
        if not standalone_mode:
            return run()
        try:
            code = run()
        except UsageError as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # its message is the whole help
                typer.echo(error.format_message(), err=True)  # type: ignore[attr-defined]
            else:
                print_error("error:", misuse(error))
            sys.exit(2)
        except typer.Abort:
            sys.exit(1)
        sys.exit(code if isinstance(code, int) else 0)


def misuse(error: Any) -> str:
    """What was wrong in the words of a command, and on a second line where its help is."""
    message, hint = _what(error), ""
    if error.ctx is not None:
        hint = f"\nhint: {error.ctx.command_path} --help"
    return f"{message}{hint}"


def _what(error: Any) -> str:
    """One line of what was wrong, without the words of the libraries that found it."""
    parameter = getattr(error, "param", None)
    name = getattr(error, "param_hint", None) or (parameter_name(parameter) if parameter is not None else "")
    kind = type(error).__name__
    if kind == "MissingParameter":
        return f"{name} is missing"
    if kind == "NoSuchOption":
        near = difflib.get_close_matches(error.option_name, error.possibilities or (), n=3, cutoff=0.5)
        return f"no such option: {error.option_name}{_near(near)}"
    if isinstance(error, typer.BadParameter):
        said = _said(error.__cause__, parameter) or _sentence(error.message)
        return f"{name}: {said}" if name else said
    if found := _EXTRA.match(error.message):
        return f"too many words: {found[1]}"
    message = _SUGGESTED.sub(lambda found: _near(found[1].replace("'", "").split(", ")), error.format_message())
    return _sentence(message)


def _sentence(text: str) -> str:
    """A sentence of Typer's as our own are written: behind a colon, and without a full stop."""
    words = re.sub("^dir(ectory)? ", "folder ", text.removesuffix("."), flags=re.IGNORECASE)
    return f"{words[:1].lower()}{words[1:]}" if words.partition(" ")[0].istitle() else words


def _said(cause: Any, parameter: Any) -> str:
    """What pydantic, by which Typer reads values, found wrong with one; empty where it did not."""
    if not hasattr(cause, "errors") or parameter is None:
        return ""
    first = cause.errors()[0]
    value, low, high = first.get("input"), getattr(parameter, "min", None), getattr(parameter, "max", None)
    if choices := parameter.type_descriptor.choices:
        words = [str(getattr(choice, "value", choice)) for choice in choices]
        near = difflib.get_close_matches(str(value), words, n=1)
        return f"{value!r} is none of {', '.join(words)}{_near(near)}"
    if first["type"].endswith(("_parsing", "_type", "from_float")):
        whole = "int" in first["type"]
        return f"{value!r} is no {'whole number' if whole else 'number'}"
    if low is not None and high is not None:
        return f"{value} is not from {low:g} to {high:g}"
    if low is not None:
        return f"{value} is less than {low:g}"
    return _sentence(str(first["msg"]).removeprefix("Value error, "))


def _near(names: list[str]) -> str:
    return f"; did you mean {', '.join(names)}?" if names else ""


def print_error(mark: str, message: str) -> None:
    """Print an error on standard error, in red where that is a terminal.

    Args:
        mark: `error:`, or `bug:` for a fault of the program.
    """
    text = Text.assemble((mark, "bold red"), " ", "\n".join(terminal_safe(line) for line in message.split("\n")))
    try:
        Console(stderr=True, soft_wrap=True).print(text, highlight=False)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
