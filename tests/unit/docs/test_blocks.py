"""Code blocks of the documents that can be judged without running them; tests/consumers/test_documents.py runs them."""

from __future__ import annotations

import ast
import json
import re
import shlex
import sqlite3
import subprocess
from pathlib import Path

import pytest
import typer
from typer.core import TyperGroup

from casa_assets.cli.main import app
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.reports import index
from tests.documents import LANGUAGES, REASONS, ROOT, Block, blocks, indented, pages

BLOCKS = [block for page in pages() for block in blocks(page)]
SHELL = [block for block in BLOCKS if block.language == "sh"]
CLI = typer.main.get_command(app)
BENCHMARKS = subprocess.check_output([ROOT / "dev", "bench"], text=True).split()


@pytest.mark.parametrize("page", pages())
def test_every_block_says_what_it_is(page: str) -> None:
    for block in blocks(page):
        assert block.language in LANGUAGES, block
        assert not block.reason or block.reason in REASONS, f"{block}: {block.reason!r} is no reason not to run it"
    assert indented(page) == []


def test_most_blocks_are_run() -> None:
    ours = [
        b
        for b in BLOCKS
        if b.page.startswith(("README", "docs/quick", "docs/howto")) and b.language in ("sh", "python")
    ]
    assert sum(not b.reason for b in ours) > 0.6 * len(ours) > 40
    python = [b for b in ours if b.page in ("README.md", "docs/howto/use/python.md") and b.language == "python"]
    assert [b for b in python if b.reason] == []


@pytest.mark.parametrize("block", SHELL, ids=str)
def test_commands_take_their_options(block: Block) -> None:
    for command in block.commands:
        words = [w for w in shlex.split(command) if not re.fullmatch(r"\w+=.*", w)]
        if words[0] == "casa-assets":
            _accepted(words[1:], block)
        elif words[0] == "./dev":
            assert f"\n  {words[1]} " in (ROOT / "dev").read_text(encoding="utf-8"), f"{block}: {command}"
            if words[1] == "bench" and len(words) > 2:
                assert words[2] in BENCHMARKS, f"{block}: {command}"
        else:
            program = Path(words[0]).name  # of an environment of its own, where a folder is named
            known = ("python", "python3", "python3.11", "python3.12", "pip", "source")
            assert program in known, f"{block}: nothing checks {command!r}"
            assert block.reason or program == "python", block


def _accepted(words: list[str], block: Block) -> None:
    """A verb and its options are those that the program has."""
    command = CLI
    while isinstance(command, TyperGroup) and words:
        assert words[0] in command.commands, f"{block}: there is no {words[0]!r}"
        command, words = command.commands[words[0]], words[1:]
    known = {name for p in command.params for name in (*p.opts, *p.secondary_opts)} | {"--help"}
    for word in words:
        if word.startswith("-"):
            assert word.partition("=")[0] in known, f"{block}: {command.name} has no {word}"


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "python"], ids=str)
def test_python_parses(block: Block) -> None:
    ast.parse(block.code)


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "json"], ids=str)
def test_json_parses(block: Block) -> None:
    assert json.loads(block.code)


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.language == "sql"], ids=str)
def test_sql_runs_on_an_index(block: Block, tmp_path: Path) -> None:
    library = Library(tmp_path)
    with library.locked():
        index.rebuild(library)
    with sqlite3.connect(next(tmp_path.glob("*.sqlite"))) as base:
        for query in filter(None, map(str.strip, block.code.split(";"))):
            base.execute(query)
