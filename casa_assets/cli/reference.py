"""Print every command with its arguments and options as Markdown: `python -m casa_assets.cli.reference`."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator
from typing import Any

import typer
from typer.core import TyperGroup

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
_STYLE = re.compile(r"\[/?(?:bold|dim|italic|cyan|green|red|yellow)[^\]]*\]")


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
    lines: list[str] = []
    for paragraph in re.split(r"\n\s*\n", _plain(text).strip()):
        said = " ".join(paragraph.split("\n")).strip() if "casa-assets " not in paragraph else paragraph.strip()
        title, _, call = said.partition("casa-assets ")
        if not call or title.strip() not in ("", "Example:", "Examples:"):
            lines.append(f"{' '.join(said.split())}\n")
            continue
        block = "\n".join(line.strip().removeprefix(title.strip()).strip() for line in said.split("\n"))
        if lines and lines[-1] == "```\n":
            lines[-1:] = [block, "```\n"]
        else:
            lines += ["```text", block, "```\n"]
    return [line for line in lines if line.strip() not in ("Examples:", "Example:")]


def _row(parameter: Any) -> str:
    is_option = parameter.param_type_name == "option"
    names = [*parameter.opts, *parameter.secondary_opts] if is_option else [parameter.name]
    default = parameter.default() if callable(parameter.default) else parameter.default
    shown = (
        "" if default in (None, "", (), [], False) or not getattr(parameter, "show_default", True) else f"`{default}`"
    )
    if default is True:
        shown = f"`{parameter.opts[0]}`"
    if parameter.required:
        shown = "needed"
    cells = [", ".join(f"`{name}`" for name in names), _plain(getattr(parameter, "help", None) or ""), shown]
    return "| " + " | ".join(" ".join(cell.split()).replace("|", "\\|") for cell in cells) + " |"


def _plain(text: str) -> str:
    return _STYLE.sub("", inspect.cleandoc(text).replace("\b\n", "")).replace("<", "&lt;")


if __name__ == "__main__":
    sys.stdout.write(commands_markdown())
