"""Help at 80 columns: whole words, whole examples, and no types of Python."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from typing import Any

import typer

from casa_assets.cli.group import help_text
from casa_assets.cli.main import app, narrowed

WIDTH = 78  # of 80 columns, as Typer counts them


def commands(command: Any, path: str) -> Iterator[tuple[str, Any]]:
    """A command or group, and all below it."""
    yield path, command
    for name, inner in getattr(command, "commands", {}).items():
        if not inner.hidden:
            yield from commands(inner, f"{path} {name}")


ALL = dict(commands(typer.main.get_command(app), "casa-assets"))


def text_of(path: str, width: int = WIDTH) -> str:
    command = ALL[path]
    return re.sub("\x1b\\[[0-9;]*m", "", help_text(command, typer.Context(command, info_name=path), width))


def blocks(text: str) -> dict[str, str]:
    """Heading of a section -> its lines."""
    parts = re.split(r"^(\w[\w ]*):$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def cut_of(path: str) -> list[str]:
    """What of the help of a command is too wide, cut off or left out at 80 columns."""
    text = text_of(path)
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


def narrow(path: str) -> list[str]:
    """Sections of the help of a command whose text has fewer than 35 columns."""
    columns = {
        title: max((len(found[0]) for line in lines.splitlines() if (found := re.match(" +", line))), default=2)
        for title, lines in blocks(text_of(path)).items()
    }
    return [title for title, column in columns.items() if WIDTH - column < 35 and not title.startswith("Example")]


def test_the_text_of_an_option_has_35_columns_and_more() -> None:
    assert {path: titles for path in ALL if (titles := narrow(path))} == {}


def test_a_command_alone_has_the_same_help_as_among_all() -> None:
    """The program makes only the command that it is called with."""
    for path, command in ALL.items():
        words = path.split()[1:]
        alone: Any = typer.main.get_command(narrowed(app, words))
        for word in words:
            alone = alone.commands[word]
        shown = help_text(alone, typer.Context(alone, info_name=path), WIDTH)
        assert shown == help_text(command, typer.Context(command, info_name=path), WIDTH), path


def test_words_that_name_no_command_are_looked_for_among_all() -> None:
    for words in ([], ["--help"], ["scene"], ["scenes", "nwe"]):
        assert narrowed(app, words) is app or words[:1] == ["scenes"]
    scenes = typer.main.get_command(narrowed(app, ["scenes", "nwe"])).commands["scenes"]  # type: ignore[attr-defined]
    assert "new" in scenes.commands
