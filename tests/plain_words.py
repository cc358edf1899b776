"""Find docstrings in the dialect that this project once had, which strangers have to read twice.

    python -m tests.plain_words FILE ...    each docstring that has a mark of it, with its line
    python -m tests.plain_words --changed   the same for files that differ from the last commit; ends with 1 if any has

A mark is a word or a turn that plain technical English has a usual word for: "the report tells" (says, reports), "where
there is none" (if there is none), "anew" (again), "a file of its own" (a separate file). `./dev lint` looks at what was
changed. A docstring may speak of things that really stand on a floor: say "is on", or "placed".
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "casa_assets"
# What each mark is called, and what is usually written instead.
MARKS = {
    "tell": (r"\btells?\b|\btold\b|\btelling\b", "say, report, decide, distinguish"),
    "stand": (r"\bstands?\b(?! mixer| by itself|:)|\bstood\b", "be, be placed, be written"),
    "where none": (r"\bwhere (?:there (?:is|are) (?:none|no)|none\b)|\b[Nn]one where\b", "if there is none; None if"),
    "is none": (r"\b(?:is|are|was|were) none\b", "is missing, does not exist"),
    "what-clause": (r"(?:^|[.:;] +)What (?!(?:is|are|does|do|was|were) [^.]*\?)[a-z]", "name the thing"),
    "anew": (r"\banew\b", "again"),
    "beside": (r"\bbeside\b", "next to, in addition to, with"),
    "of its own": (r"\bof (?:its|their|one's|his) own\b", "separate, own"),
    "so many": (r"\bso (?:many|much)\b", "this number of, more"),
}
PATTERNS = {name: re.compile(pattern, re.MULTILINE) for name, (pattern, _) in MARKS.items()}


@dataclass(frozen=True)
class Marked:
    """A docstring with marks.

    Attributes:
        file: path. line: of the docstring. owner: name of its function, class or module. marks: names, of `MARKS`.
    """

    file: Path
    line: int
    owner: str
    marks: tuple[str, ...]
    text: str


def marks_of(text: str) -> tuple[str, ...]:
    """Names of the marks that a text has."""
    return tuple(name for name, pattern in PATTERNS.items() if pattern.search(text))


def docstrings(path: Path) -> Iterator[tuple[int, str, str]]:
    """Line, owner and text of each docstring of a Python file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            text = ast.get_docstring(node)
            if text is not None:
                yield node.body[0].lineno, getattr(node, "name", path.stem), text


def marked(paths: Iterable[Path]) -> tuple[list[Marked], int]:
    """Docstrings with marks, and the number of all docstrings."""
    found, count = [], 0
    for path in paths:
        for line, owner, text in docstrings(path):
            count += 1
            if marks := marks_of(text):
                found.append(Marked(path, line, owner, marks, text))
    return found, count


def changed_files() -> list[Path]:
    """Python files of the package that differ from the last commit, or are new."""
    words = ("git", "status", "--porcelain", "--untracked-files=all", "--", PACKAGE.name)
    lines = subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    paths = (ROOT / line[3:].rpartition(" -> ")[2].strip('"') for line in lines)
    return [path for path in paths if path.suffix == ".py" and path.is_file()]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, help="Python files")
    parser.add_argument("--changed", action="store_true", help="files that differ from the last commit")
    arguments = parser.parse_args()
    found, _ = marked([path.resolve() for path in arguments.files] or changed_files())
    for one in found:
        instead = "; ".join(f"{name} ({MARKS[name][1]})" for name in one.marks)
        print(f"{one.file.relative_to(ROOT)}:{one.line}: {one.owner}: write {instead}")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
