"""Tables in terminals of several widths and in a pipe: every name whole, no column of single letters."""

from __future__ import annotations

import pytest
from rich.console import Console
from rich.text import Text

from casa_assets.cli.output import TextTable

ID, PATH = "mug_fb61aea070", "some/rather/long/folder/g_nonmanifold_fin_of_a_mug.glb"
SENTENCE = "the bounding box is larger than that of any mug, so that the unit of the file may be another one"


def printed(width: int, is_terminal: bool, sentence: str = SENTENCE) -> list[str]:
    console = Console(width=width, force_terminal=is_terminal, color_system=None, force_interactive=False)
    table = TextTable(("asset", "mass", "why", "source"), sentences=("why",), right=("mass",), title="In review")
    table.add(ID, "292 g", sentence, PATH)
    table.add(Text("b", style="red"), "1.2 kg", "", "[b].glb")
    with console.capture() as taken:
        table.print(console)
    return taken.get().splitlines()


def test_names_are_whole_at_every_width(subtests: pytest.Subtests) -> None:
    for width in [20, 40, 60, 80, 100, 140, 200]:
        with subtests.test(width=width):
            lines = printed(width, is_terminal=True)
            text = "\n".join(lines)
            for word in (ID, "292 g", PATH, "[b].glb"):
                assert word in text
            assert "…" not in text
            for word in SENTENCE.split():
                assert word in text
            assert not [line for line in lines if len(line.strip()) == 1 and line.strip() != "b"]


def test_no_line_is_wider_than_the_terminal(subtests: pytest.Subtests) -> None:
    for width in [80, 100, 140, 200]:
        with subtests.test(width=width):
            assert max(map(len, printed(width, is_terminal=True, sentence="size"))) <= width


@pytest.mark.parametrize("width", [20, 80])
def test_a_pipe_gets_one_line_for_each_row(width: int) -> None:
    title, heads, _, first, second = printed(width, is_terminal=False)
    assert title == "In review"
    assert heads.split() == ["asset", "mass", "why", "source"]
    assert first.split()[0] == ID
    assert first.endswith(PATH)
    assert SENTENCE in first
    assert second.split() == ["b", "1.2", "kg", "[b].glb"]


def test_sentences_are_wrapped_between_words() -> None:
    console = Console(width=40, force_terminal=True, color_system=None)
    table = TextTable(("code", "what"), sentences=("what",))
    table.add("SRC001", SENTENCE)
    with console.capture() as taken:
        table.print(console)
    lines = taken.get().splitlines()
    assert max(map(len, lines)) <= 40
    assert " ".join(" ".join(line.removeprefix("SRC001").split()) for line in lines[2:]) == SENTENCE
