"""Sizes, docstrings, and what may stand in a source file."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "casa_assets"
SOURCES = sorted(PACKAGE.rglob("*.py"))
FILE_LINES = 300
FAMILY_FILE_LINES = 400
FUNCTION_LINES = 60

# Read-only text of the project; built things and what the user makes are not ours to judge.
TEXT_SUFFIXES = {"", ".cfg", ".csv", ".json", ".md", ".obj", ".mtl", ".py", ".sh", ".toml", ".txt", ".yaml", ".yml"}
SKIPPED = re.compile(r"^(\.git|\.venv.*|\..*_cache|\.hypothesis|out|build|dist|__pycache__)$")

# Written in two halves, so that this file does not hold them.
FORBIDDEN = [
    re.compile("/wo" + r"rk/"),
    re.compile("/ro" + r"ot/"),
    re.compile("/ho" + r"me/[a-z]"),
    re.compile(r"https?://[^\s)>\"']*(pypi|pytho" + r"nhosted)", re.IGNORECASE),
    re.compile("(extra-)?index-u" + "rl"),
]


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


def public(tree: ast.Module | ast.ClassDef) -> Iterator[ast.FunctionDef | ast.ClassDef]:
    """Public functions and classes of a module, and the public methods of those classes."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                yield from public(node)


def texts() -> Iterator[Path]:
    folders = [ROOT]
    while folders:
        for path in sorted(folders.pop().iterdir()):
            if SKIPPED.match(path.name):
                continue
            if path.is_dir():
                folders.append(path)
            elif path.suffix in TEXT_SUFFIXES:
                yield path


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
class TestSource:
    def test_file_is_short(self, path: Path) -> None:
        limit = FAMILY_FILE_LINES if "families" in path.parts else FILE_LINES
        assert len(path.read_text(encoding="utf-8").splitlines()) <= limit

    def test_functions_are_short(self, path: Path) -> None:
        lengths = {f.name: (f.end_lineno or f.lineno) - f.lineno + 1 for f in functions(tree_of(path))}
        assert {name: n for name, n in lengths.items() if n > FUNCTION_LINES} == {}

    def test_no_error_is_swallowed(self, path: Path) -> None:
        for node in ast.walk(tree_of(path)):
            if not isinstance(node, ast.ExceptHandler):
                continue
            assert node.type is not None, f"line {node.lineno}: bare except"
            caught = {name.id for name in ast.walk(node.type) if isinstance(name, ast.Name)}
            idle = all(
                isinstance(s, ast.Pass | ast.Continue)
                or (isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant))
                for s in node.body
            )
            broad = caught & {"Exception", "BaseException"}
            assert not (broad and idle), f"line {node.lineno}: swallows everything"

    def test_only_the_cli_prints(self, path: Path) -> None:
        if "cli" in path.relative_to(PACKAGE).parts:
            return
        calls = (node for node in ast.walk(tree_of(path)) if isinstance(node, ast.Call))
        assert [c.lineno for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"] == []

    def test_module_and_public_names_are_documented(self, path: Path) -> None:
        tree = tree_of(path)
        if tree.body:
            assert ast.get_docstring(tree), "the module says nothing"
        assert [node.name for node in public(tree) if not ast.get_docstring(node)] == []


def test_the_package_is_found() -> None:
    assert len(SOURCES) > 10


def test_no_machine_or_index_is_named() -> None:
    found = [
        f"{name_of(path)}:{number}: {pattern.pattern}"
        for path in texts()
        for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1)
        for pattern in FORBIDDEN
        if pattern.search(line)
    ]
    assert found == []


def test_constraints_are_names_and_versions() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert pins
    assert [line for line in pins if not re.fullmatch(r"[A-Za-z0-9_.-]+==[A-Za-z0-9_.+!-]+", line)] == []
