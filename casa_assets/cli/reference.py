"""Pages about all commands, one for each: `python -m casa_assets.cli.reference docs/reference` writes them."""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from casa_assets.cli.group import help_parts
from casa_assets.cli.main import app

HEAD = """# Commands

Printed from the program by `./dev docs`. `casa-assets COMMAND --help` says the same in a terminal, and what each exit
code means for that command.

| exit code | meaning |
|---|---|
| 0 | all was accepted, made or found |
| 1 | some was rejected, failed or not found |
| 2 | misuse, a place that cannot be written to, or a machine that lacks something |
| 3 | a fault of the program |
| 4 | none was rejected, but a person has to decide something (`casa-assets review`) |
| 130, 143 | stopped by Ctrl-C or by a signal; the same command goes on from there |
"""
# Meaning of the exit codes of one command: the overview has that of all. A full stop inside of a file name is no end.
_EXIT_CODES = re.compile(r"\s*Exit 0(?:[^.]|\.(?=\S))*\.")
# An option that this number of commands have in the same words is described once, in the overview.
MANY = 5


def command_pages() -> dict[str, str]:
    """Path below docs/reference -> Markdown: an overview, and a page for each verb with the verbs below it."""
    root: Any = typer.main.get_command(app)
    verbs = {name: verb for name, verb in root.commands.items() if not verb.hidden}
    commands = [c for name, verb in verbs.items() for _, c in _commands(verb, name) if not isinstance(c, TyperGroup)]
    counts = Counter(_line(option) for command in commands for option in _parameters(command, "option"))
    common = {line for line, count in counts.items() if count >= MANY}
    usual = {line for line, count in counts.items() if count > 0.75 * len(commands)}
    lines = [HEAD, "| command | |", "|---|---|"]
    pages = {}
    for name, verb in verbs.items():
        about = help_parts(verb.help or "")[0][0].replace("<", "&lt;")
        lines.append(f"| [{name}](commands/{name}.md) | {about} |")
        sections = [line for path, one in _commands(verb, name) for line in _section(path, one, common, usual)]
        pages[f"commands/{name}.md"] = "\n".join(sections).rstrip("\n") + "\n"
    lines += ["", "## Options of nearly every command", "", *sorted(usual)]
    lines += ["", "## Options of many commands", "", *sorted(common - usual)]
    return {"commands.md": "\n".join(lines) + "\n", **pages}


def _commands(command: Any, path: str) -> Iterator[tuple[str, Any]]:
    yield path, command
    if isinstance(command, TyperGroup):
        for name, inner in command.commands.items():
            if not inner.hidden:
                yield from _commands(inner, f"{path} {name}")


def _parameters(command: Any, kind: str) -> list[Any]:
    return [p for p in command.params if p.param_type_name == kind and not p.hidden and p.name != "help"]


def _section(path: str, command: Any, common: set[str], usual: set[str]) -> list[str]:
    title = f"{'##' if ' ' in path else '#'} casa-assets {path}\n"
    prose, examples = help_parts(command.help or "")
    paragraphs = (_EXIT_CODES.sub("", paragraph).strip().replace("<", "&lt;") for paragraph in prose)
    lines = [title, *(f"{paragraph}\n" for paragraph in paragraphs if paragraph)]
    lines += ["```text", *(line.strip() for line in examples), "```\n"] if examples else []
    if isinstance(command, TyperGroup):
        return lines
    options = [_line(p) for p in _parameters(command, "option")]
    own = [_line(p) for p in _parameters(command, "argument")] + [line for line in options if line not in common]
    also = [line.removeprefix("- ").split(":")[0] for line in options if line in common - usual]
    link = "[options of many commands](../commands.md#options-of-many-commands)"
    return [*lines, *own, *([f"- {', '.join(also)}: {link}."] if also else []), ""]


def _line(parameter: Any) -> str:
    """A bullet: the names of an option or argument, what it is, and its default."""
    is_option = parameter.param_type_name == "option"
    names = [*parameter.opts, *parameter.secondary_opts] if is_option else [parameter.name.upper()]
    default = parameter.default() if callable(parameter.default) else parameter.default
    shown = ""
    if default is True:
        shown = f" Default: `{parameter.opts[0]}`."
    elif default not in (None, "", (), [], False) and getattr(parameter, "show_default", True):
        shown = f" Default: `{default}`."
    if parameter.required:
        shown = " Needed."
    words = " ".join((getattr(parameter, "help", None) or "").split()).replace("<", "&lt;")
    return f"- {', '.join(f'`{name}`' for name in names)}: {words}{shown}"


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for old in folder.glob("commands/*.md"):
        old.unlink()
    (folder / "commands").mkdir(exist_ok=True)
    for path, text in command_pages().items():
        (folder / path).write_text(text, encoding="utf-8")
