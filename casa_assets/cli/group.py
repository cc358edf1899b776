"""The classes of commands and groups: their help, options that all commands share, and one form for errors of use."""

from __future__ import annotations

import difflib
import inspect
import os
import re
import resource
import sys
import textwrap
import time
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text
from typer.core import TyperCommand, TyperGroup

from casa_assets.cli.output import terminal_safe
from casa_assets.projects import (
    NO_PROJECT,
    SETTINGS,
    VARIABLE,
    PluginUse,
    choose_plugins,
    find_project,
    plugin_use,
    project_folder,
    use_project,
)

# Sections in which options are shown; those of no section come first, those of all verbs last.
LIMITS, CLUSTER, GENERAL = "Limits", "Cluster", "General"
OPTIONS, ARGUMENTS, COMMANDS = "Options", "Arguments", "Commands"
LAST = (LIMITS, CLUSTER, GENERAL)
INDENT = "  "
NAMES_WIDTH = 30  # of the column of names; the text of a longer one begins on the next line
MOST_CHOICES = 28  # characters of choices that are printed beside the name of an option
_NUMBERS = {"int": "N", "float": "X"}
NAME = "casa-assets"  # of the program, however it was started
PROJECT_HELP = f"Folder with a {SETTINGS}; by default this one or the nearest above it; '{NO_PROJECT}': none."
PLUGINS_HELP = "Run the code in plugins/ of the project; or none, not even of installed packages."
# Raised by Typer for any wrong use; it exports one class of these alone.
UsageError: type[Exception] = typer.BadParameter.__mro__[1]
_EXTRA = re.compile(r"Got unexpected extra argument(?:s|\(s\))? \((.*)\)")
_SUGGESTED = re.compile(r"\. Did you mean (.*)\?")
_general = partial(typer.Option, rich_help_panel=GENERAL, expose_value=False)
_from_variable = partial(_general, envvar=VARIABLE, show_envvar=False, is_eager=True)


def help_text(command: Any, ctx: Any, width: int) -> str:
    """The help of a command or a group of commands, on lines of `width` characters."""
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
    """The words behind the name of a command in its usage: `[OPTIONS]`, `SOURCES...`, `[LIBRARY]` if it may lack."""
    pieces = [command.options_metavar or ""]
    for argument in (p for p in command.get_params(ctx) if p.param_type_name == "argument"):
        name = parameter_name(argument) if argument.required else f"[{parameter_name(argument)}]"
        pieces.append(name + "..." * (argument.nargs != 1))
    return [piece for piece in (*pieces, getattr(command, "subcommand_metavar", "")) if piece]


def parameter_name(parameter: Any) -> str:
    """An argument in capitals, an option by its long name."""
    if parameter.param_type_name == "argument":
        return str(parameter.metavar or str(parameter.name).upper().strip("_"))
    return str(next((name for name in parameter.opts if name.startswith("--")), parameter.opts[0]))


def value_name(parameter: Any) -> str:
    """Placeholder for the value of an option, such as `N`, `DIR` or `local|ray`; empty for a flag."""
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
    """The default of a parameter as a user would write it; empty if there is no default worth showing."""
    shown = getattr(parameter, "show_default", True)
    if isinstance(shown, str):
        return shown
    default = parameter.default() if callable(parameter.default) else parameter.default
    if not shown or default in (None, "", (), [], False):
        return "off" if default is False and parameter.secondary_opts and shown else ""
    return "on" if default is True else str(getattr(default, "value", default))


def _option(parameter: Any) -> str:
    """The names of an option with the placeholder of its value: `-q, --quiet`, `--jobs N`, `--[no-]pictures`."""
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


class _Helped:
    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help."""
        formatter.write(help_text(self, ctx, formatter.width))

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """The words behind the name in the usage."""
        return usage_pieces(self, ctx)


class Group(_Helped, TyperGroup):
    """Commands under a common word."""

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


def group_of(name: str, about: str) -> typer.Typer:
    """Return a group to which commands are added."""
    return typer.Typer(name=name, cls=Group, help=about, no_args_is_help=True)


def misuse(error: Any) -> str:
    """A description of what was wrong in the words of a command, and a second line that names its help."""
    hint = "" if error.ctx is None else f"\nhint: {error.ctx.command_path} --help"
    return f"{_what(error)}{hint}"


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
        fault = _fault_of_value(error.__cause__, parameter) or _sentence(error.message)
        return f"{name}: {fault}" if name else fault
    if found := _EXTRA.match(error.message):
        return f"too many words: {found[1]}"
    message = _SUGGESTED.sub(lambda found: _near(found[1].replace("'", "").split(", ")), error.format_message())
    return _sentence(message)


def _sentence(text: str) -> str:
    """A sentence of Typer's as our own are written: behind a colon, and without a full stop."""
    words = re.sub("^dir(ectory)? ", "folder ", text.removesuffix("."), flags=re.IGNORECASE)
    return f"{words[:1].lower()}{words[1:]}" if words.partition(" ")[0].istitle() else words


def _fault_of_value(cause: Any, parameter: Any) -> str:
    """The fault that pydantic, by which Typer reads values, found in a value; empty if it found none."""
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
    """Print an error behind a mark, such as `error:`, on standard error, in red where that is a terminal."""
    text = Text.assemble((mark, "bold red"), " ", "\n".join(terminal_safe(line) for line in message.split("\n")))
    try:
        Console(stderr=True, soft_wrap=True).print(text, highlight=False)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


class Verb(_Helped, TyperCommand):
    """A verb of the command line, with the options that all verbs share."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.params += _options_of_all()

    def invoke(self, ctx: Any) -> Any:
        """Run the verb; with --verbose, say on standard error what it took."""
        begin = time.monotonic()
        try:
            return super().invoke(ctx)
        finally:
            if ctx.params.get("verbose"):
                typer.echo(_spent(time.monotonic() - begin), err=True)


@lru_cache(maxsize=1)
def _options_of_all() -> tuple[Any, ...]:
    """The options of every verb, made by Typer of a command that has no others."""
    single = typer.Typer(add_completion=False)
    single.command()(_with_project)
    named = {name: p for p in typer.main.get_command(single).params for name in p.opts}
    return (named["--project"], named["--plugins"])


def _on_project(ctx: typer.Context, named: str) -> None:
    """Use the project that is named, or else the nearest at or above the working folder. Raises CasaError."""
    if ctx.resilient_parsing:
        return
    if named:
        use_project(None if named == NO_PROJECT else Path(named))
    elif (found := find_project(Path())) is not None:
        use_project(found)


def _on_plugins(ctx: typer.Context, wanted: bool | None) -> None:
    """Have the plug-ins run that are asked for; say which of the project do not."""
    if ctx.resilient_parsing:
        return
    if wanted is not None:
        choose_plugins(PluginUse.ALL if wanted else PluginUse.NONE)
    folder = project_folder()
    if folder is not None and plugin_use() is PluginUse.INSTALLED and any((folder / "plugins").glob("*.py")):
        from casa_assets.registry.plugins import ignored_files

        if ignored_files():
            message = f"the code in {folder / 'plugins'} does not run; add --plugins if you trust it"
            typer.echo(f"note: {message}, or --no-plugins", err=True)


def _with_project(
    project: Annotated[str, _from_variable("--project", metavar="DIR", help=PROJECT_HELP, callback=_on_project)] = "",
    plugins: Annotated[
        bool | None, _general("--plugins/--no-plugins", help=PLUGINS_HELP, show_default=False, callback=_on_plugins)
    ] = None,
) -> None: ...


def _spent(wall_s: float) -> str:
    """Seconds, processor seconds and memory of this process and of those that it waited for."""
    own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    cpu_s = sum(usage.ru_utime + usage.ru_stime for usage in (own, others))
    peak = max(own.ru_maxrss, others.ru_maxrss) * (1 if sys.platform == "darwin" else 1024)  # Ref: getrusage(2)
    return f"took {wall_s:.1f} s, {cpu_s:.1f} s of processor time; the largest process had {peak / 1e6:.0f} MB"
