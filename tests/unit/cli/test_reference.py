"""The pages about commands that are kept in docs/reference are those of this program."""

from __future__ import annotations

from casa_assets.cli.reference import command_pages
from tests.support.program.documents import ROOT

REFERENCE = ROOT / "docs" / "reference"


def test_pages_are_up_to_date() -> None:
    found = [REFERENCE / "commands.md", *REFERENCE.glob("commands/*.md")]
    written = {path.relative_to(REFERENCE).as_posix(): path.read_text(encoding="utf-8") for path in found}
    assert written == command_pages(), "run ./dev docs"


def test_options_of_many_commands_are_described_once() -> None:
    pages = command_pages()
    assert sum("Of a running Ray cluster" in text for text in pages.values()) == 1
    assert "`--address`" in pages["commands/ingest.md"]
    assert "`--max-faces`" in pages["commands/ingest.md"]
