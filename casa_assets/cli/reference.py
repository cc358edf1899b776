"""Print every command with its arguments and options as Markdown: `python -m casa_assets.cli.reference`."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from typing import Any

import typer
from typer.core import TyperGroup

from casa_assets.cli.help import default_text, help_parts
from casa_assets.cli.main import app

HEAD = """# Commands

Printed from the program. `casa-assets COMMAND --help` says the same in a terminal.

| exit code | meaning |
|---|---|
| 0 | all was accepted, made or found |
| 1 | some was rejected, failed or not found |
| 2 | misuse, a place that cannot be written to, or a machine that lacks something |
| 3 | a fault of the program |
| 4 | none was rejected, but a person has to decide something (`casa-assets review`) |
| 130, 143 | stopped by Ctrl-C or by a signal; the same command goes on from there |
"""


def commands_markdown() -> str:
    """The page of commands of the site: a section for each verb, in the order of `casa-assets --help`."""
    lines = [HEAD]
    for path, command in _commands(typer.main.get_command(app), "casa-assets"):
        lines += _section(path, command)
    return "\n".join(lines)


def _commands(command: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Commands of a group and of the groups in it, each with the words that call it."""
    for name in command.commands:
        inner = command.commands[name]
        if inner.hidden:
            continue
        yield f"{path} {name}", inner
        if isinstance(inner, TyperGroup):
            yield from _commands(inner, f"{path} {name}")


def _section(path: str, command: Any) -> list[str]:
    if isinstance(command, TyperGroup):
        return [f"## {path}\n", *_help(command.help or "")]
    level = "##" if path.count(" ") == 1 else "###"
    arguments = [p for p in command.params if p.param_type_name == "argument" and not p.hidden]
    options = [p for p in command.params if p.param_type_name == "option" and not p.hidden]
    usage = " ".join([path, *command.collect_usage_pieces(typer.Context(command))])
    lines = [f"{level} {path}\n", "```text", usage, "```\n", *_help(command.help or "")]
    if arguments or options:
        lines += ["| argument or option | what it is | default |", "|---|---|---|"]
        lines += [_row(p) for p in (*arguments, *options)]
        lines.append("")
    return lines


def _help(text: str) -> list[str]:
    """Paragraphs of a help text; example calls stand together in one block."""
    prose, examples = help_parts(text)
    block = ["```text", *examples, "```\n"] if examples else []
    return [*(f"{paragraph}\n" for paragraph in map(_plain, prose)), *block]


def _row(parameter: Any) -> str:
    names = [*parameter.opts, *parameter.secondary_opts] if parameter.param_type_name == "option" else [parameter.name]
    default = default_text(parameter)
    shown = "needed" if parameter.required else f"`{default}`" if default else ""
    cells = [", ".join(f"`{name}`" for name in names), _plain(parameter.help or ""), shown]
    return "| " + " | ".join(" ".join(cell.split()).replace("|", "\\|") for cell in cells) + " |"


def _plain(text: str) -> str:
    return inspect.cleandoc(text).replace("<", "&lt;")


if __name__ == "__main__":
    sys.stdout.write(commands_markdown())
