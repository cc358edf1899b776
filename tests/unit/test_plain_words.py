"""Docstrings that a stranger has to read twice are found; plain ones are not."""

from __future__ import annotations

from pathlib import Path

from tests.plain_words import marked, marks_of

MARKS = {
    "The report tells which joints fail.": {"tell"},
    "Rows stand in a file of their own, and None where there is none.": {"stand", "where none", "of its own"},
    "What is left is written anew, beside the rest.": {"what-clause", "anew", "beside"},
    "Return the joints that fail, or None if all pass.": set(),
    "Parts of stand mixers: the head, and the tools that hang from it.": set(),
}


def test_marks_are_found_docstring_by_docstring(tmp_path: Path) -> None:
    for text, marks in MARKS.items():
        assert marks <= set(marks_of(text)), text
        assert bool(marks) is bool(marks_of(text)), text
    path = tmp_path / "rows.py"
    path.write_text('"""Rows of a table."""\n\n\ndef row() -> None:\n    """Write it anew."""\n', encoding="utf-8")
    found, count = marked([path])
    assert count == 2
    assert [(one.owner, one.line, one.marks) for one in found] == [("row", 5, ("anew",))]
