"""Which test files reach a file of this project, nearest first.

A test file reaches what it imports, what that imports, and so on: `import` statements anywhere in a file, but for those
under TYPE_CHECKING; modules named in text, such as `"casa_assets.ingest.run.steps:work"`; and what the fixtures
of a conftest.py import that the test file names. Its distance to a file is the number of steps on the shortest way.

    ordered = reaching(Imports(root), ["casa_assets/formats/mjcf/document.py"])

Tests that start the program reach all of it, and come after those that import what was changed. Nothing is imported:
files are read as text, so that any checkout can be asked about.

`python -m tests.selection` prints the test files that `./dev test --changed` runs: the nearest to what was changed, as
many as fit into two minutes on two cores, and a few that start the program.
"""

from __future__ import annotations

import argparse
import ast
import json
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

PACKAGE = "casa_assets"
# Folders whose Python files are read.
FOLDERS = (PACKAGE, "tests", "benchmarks", "examples")
# Text of a test by which it starts the program.
PROGRAM = ("casa-assets", f"{PACKAGE}.cli.main")
# What a test needs that is in none of the other files: these are no part of the everyday tests.
LEFT_OUT = "tests/consumers/"
CONFTEST = "conftest.py"
# Seconds that the tests of a file take on an idle core, by its path (--record); what one takes that is not there.
SECONDS, USUAL_S = Path(__file__).with_name("seconds.json"), 2.0
# Of all that is chosen, on one core; with what two workers need to begin it is 190 s. What takes longer than LONG_S has
# to import what was changed itself.
BUDGET_S, LONG_S = 150.0, 50.0
# Run after every change of the program or its data: each goes from an input to what is written, in seconds.
SMOKE = (
    "tests/unit/cli/test_output.py",
    "tests/unit/cli/test_help.py",
    "tests/unit/runs/remote/test_push_and_pull.py",
    "tests/unit/show/reports/test_page_template.py",
    "tests/unit/export/test_exports.py",
    "tests/unit/test_examples.py",
)


@dataclass(frozen=True)
class Reaching:
    """A test file that reaches what was changed.

    Attributes:
        path: of the test file, relative to the checkout, with `/`.
        steps: number of imports from the test file to what was changed; None where it only starts the program.
    """

    path: str
    steps: int | None


class Imports:
    """What the Python files of a checkout import; all paths are relative to its folder, with `/`."""

    def __init__(self, root: Path) -> None:
        self.root = root
        places = (path for folder in FOLDERS for path in sorted((root / folder).rglob("*.py")))
        self.files = {path.relative_to(root).as_posix(): _Scan(path.read_text(encoding="utf-8")) for path in places}

    @cached_property
    def tests(self) -> list[str]:
        """Test files, but for those that need other programs."""
        return [
            path
            for path in self.files
            if path.startswith("tests/") and not path.startswith(LEFT_OUT) and _name(path).startswith("test_")
        ]

    @cached_property
    def edges(self) -> dict[str, set[str]]:
        """What each file imports by itself, and what the fixtures that it names import."""
        found = {path: self._resolved(scan.imports | scan.modules) - {path} for path, scan in self.files.items()}
        for path in self.tests:
            found[path] |= self._by_fixtures(path)
        return found

    @cached_property
    def importers(self) -> dict[str, set[str]]:
        """The other way round: who imports each file."""
        found: dict[str, set[str]] = {path: set() for path in self.files}
        for path, targets in self.edges.items():
            for target in targets:
                found[target].add(path)
        return found

    @cached_property
    def starting(self) -> list[str]:
        """Test files that start the program, by themselves or by a file of tests/ that they import."""
        own = {p for p, scan in self.files.items() if p.startswith("tests/") and scan.texts & set(PROGRAM)}
        waiting, seen = list(own), set(own)
        while waiting:
            more = {p for p in self.importers[waiting.pop()] if p.startswith("tests/")} - seen
            seen |= more
            waiting += more
        return [path for path in self.tests if path in seen]

    def reach(self, path: str) -> set[str]:
        """All that a file reaches by imports, itself included."""
        return set(_steps([path], self.edges))

    def _resolved(self, names: Iterable[str]) -> set[str]:
        """Files of dotted names, each the name of a module or of something in it."""
        found = set()
        for name in names:
            place = self._file(name) or self._file(name.rpartition(".")[0])
            if place is not None:
                found.add(place)
        return found

    def _file(self, module: str) -> str | None:
        stem = module.replace(".", "/")
        # Modules of examples/ are imported by their bare names.
        places = (f"{stem}.py", f"{stem}/__init__.py", f"examples/{stem}.py")
        return next((place for place in places if module and place in self.files), None)

    def _by_fixtures(self, test: str) -> set[str]:
        """What the fixtures import that a test file names and that a conftest.py above it defines."""
        wanted, seen = list(self.files[test].arguments), set[str]()
        places = ((folder / CONFTEST).as_posix() for folder in PurePosixPath(test).parents)
        above = [self.files[path] for path in places if path in self.files]
        found: set[str] = set()
        while wanted:
            name = wanted.pop()
            if name not in seen:
                seen.add(name)
                for scan in above:
                    if name in scan.fixtures:
                        found |= self._resolved(scan.fixtures[name].imports)
                        wanted += scan.fixtures[name].arguments
        return found


def reaching(imports: Imports, changed: Iterable[str]) -> list[Reaching]:
    """Test files that reach changed files, nearest first; then those that only start the program.

    Args:
        changed: paths relative to the checkout. One that is no Python file, such as a row of registry/, counts as
            changed what names it, or its folder, in text; a conftest.py counts as changed the tests below it.

    Returns:
        Of those at the same distance, the first have more of their path in common with what was changed, then they are
        those that reach less: what goes wrong there is more likely to be due to the change.
    """
    paths = [PurePosixPath(path) for path in changed]
    starts = sorted({start for path in paths for start in _starts(imports, path.as_posix())})
    steps = _steps(starts, imports.importers)
    words = {part for path in paths for part in path.with_suffix("").parts}

    def rank(test: str) -> tuple[int, int, int, str]:
        parts = set(PurePosixPath(test.replace("/test_", "/")).with_suffix("").parts)
        return steps.get(test, 0), -len(words & parts), len(imports.reach(test)), test

    near = sorted((test for test in imports.tests if test in steps), key=rank)
    program = any(path.startswith(f"{PACKAGE}/") for path in starts)
    far = sorted((test for test in imports.starting if program and test not in steps), key=rank)
    return [Reaching(test, steps[test]) for test in near] + [Reaching(test, None) for test in far]


def chosen(tests: Iterable[Reaching], seconds: Mapping[str, float], smoke: Sequence[str] = ()) -> tuple[list[str], int]:
    """Paths of the nearest test files that fit into the budget and then of `smoke`, and the number of the others.

    Args:
        tests: nearest first. seconds: that the tests of a file take, by its path. smoke: what runs in any case.
    """
    left, found = BUDGET_S - sum(seconds.get(path, USUAL_S) for path in smoke), list[str]()
    others = [test for test in tests if test.path not in smoke]
    for test in others:
        takes = seconds.get(test.path, USUAL_S)
        is_near = test.steps is not None and (test.steps <= 1 or takes <= LONG_S)
        if is_near and takes <= left:
            found.append(test.path)
            left -= takes
    return [*found, *smoke], len(others) - len(found)


def _starts(imports: Imports, path: str) -> Iterator[str]:
    """The Python files that a changed file stands for."""
    if _name(path) == CONFTEST:
        folder = path.removesuffix(CONFTEST)
        yield from (test for test in imports.tests if test.startswith(folder))
    elif path in imports.files:
        yield path
    elif not path.endswith(".py"):
        place = PurePosixPath(path)
        names = {place.name, place.stem, *(part for part in place.parent.parts[1:])}
        yield from (file for file, scan in imports.files.items() if names & scan.texts)


def _steps(starts: Iterable[str], edges: dict[str, set[str]]) -> dict[str, int]:
    """Number of edges from the nearest start to each node that can be reached."""
    found = dict.fromkeys(starts, 0)
    layer, count = list(found), 0
    while layer:
        count += 1
        layer = sorted({target for node in layer for target in edges.get(node, ())} - found.keys())
        found |= dict.fromkeys(layer, count)
    return found


def _name(path: str) -> str:
    return path.rpartition("/")[2]


@dataclass(frozen=True)
class _Fixture:
    """A fixture. imports: dotted names that its body uses. arguments: names of fixtures that it takes."""

    imports: frozenset[str]
    arguments: tuple[str, ...]


class _Scan:
    """What stands in the text of one file.

    Attributes:
        imports: dotted names. texts: constants of text, those of the form module:function cut to the module.
        modules: those of them that begin as names of modules of the package do.
        arguments: names of arguments of functions, and of fixtures that a mark asks for. fixtures: by name.
    """

    def __init__(self, text: str) -> None:
        tree = ast.parse(text)
        nodes = list(_run_nodes(tree))
        constants = (n.value for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str))
        self.texts = frozenset(value.partition(":")[0] for value in constants if len(value) < 200)
        self.modules = frozenset(value for value in self.texts if value.startswith(f"{PACKAGE}."))
        bound = [pair for node in nodes if isinstance(node, ast.Import | ast.ImportFrom) for pair in _bound(node)]
        self.imports = frozenset(name for _, name in bound)
        functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
        marks = (n.args for n in nodes if isinstance(n, ast.Call) and getattr(n.func, "attr", "") == "usefixtures")
        marked = {arg.value for args in marks for arg in args if isinstance(arg, ast.Constant)}
        self.arguments = tuple(sorted({a for f in functions for a in _arguments(f)} | {str(name) for name in marked}))
        by_name: dict[str, set[str]] = {}
        for name, module in bound:
            by_name.setdefault(name, set()).add(module)
        # What every test gets by itself tells nothing.
        marks = {f: [m for m in map(ast.unparse, f.decorator_list) if "autouse=True" not in m] for f in functions}
        self.fixtures = {f.name: _fixture(f, by_name) for f in functions if any("fixture" in m for m in marks[f])}


def _run_nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those that only type checkers see."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            waiting += node.orelse
            continue
        yield node
        waiting += ast.iter_child_nodes(node)


def _bound(node: ast.Import | ast.ImportFrom) -> Iterator[tuple[str, str]]:
    """Names that an import binds, and the dotted names that they stand for; a version leads to no code."""
    for alias in node.names:
        if isinstance(node, ast.Import):
            yield alias.asname or alias.name.partition(".")[0], alias.name
        elif alias.name != "__version__":
            yield alias.asname or alias.name, f"{node.module}.{alias.name}"


def _arguments(function: ast.FunctionDef | ast.AsyncFunctionDef) -> list[str]:
    return [a.arg for a in (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)]


def _fixture(function: ast.FunctionDef | ast.AsyncFunctionDef, imports: dict[str, set[str]]) -> _Fixture:
    used = {node.id for part in function.body for node in ast.walk(part) if isinstance(node, ast.Name)}
    found = {module for name in used for module in imports.get(name, ())}
    return _Fixture(frozenset(found), tuple(_arguments(function)))


def changed_files(root: Path, base: str | None) -> list[str]:
    """Files of a checkout that differ from a commit; without one, from the last or, if none does, in the last.

    Raises:
        subprocess.CalledProcessError: there is no such commit.
    """
    fresh = _git(root, "ls-files", "--others", "--exclude-standard")
    found = _git(root, "diff", "--name-only", "--no-renames", base or "HEAD") + fresh
    return found if found or base is not None else _git(root, "diff", "--name-only", "--no-renames", "HEAD~1", "HEAD")


def _git(root: Path, *words: str) -> list[str]:
    ran = subprocess.run(["git", *words], cwd=root, check=True, stdout=subprocess.PIPE, text=True)
    return ran.stdout.splitlines()


def seconds_of(junit: Path, root: Path) -> dict[str, float]:
    """Seconds of each test file, from what `./dev test --junitxml FILE` wrote on an idle machine."""
    found: dict[str, float] = {}
    for case in ElementTree.parse(junit).iter("testcase"):
        parts = case.attrib["classname"].split(".")
        places = ("/".join(parts[:count]) + ".py" for count in range(len(parts), 0, -1))
        path = next((place for place in places if (root / place).is_file()), None)
        if path is not None:
            found[path] = found.get(path, 0.0) + float(case.attrib["time"])
    return {path: round(found[path], 1) for path in sorted(found)}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.selection", description="Choose the tests near a change.")
    parser.add_argument("files", nargs="*", help="changed files; those that differ from the base if none is given")
    parser.add_argument("--base", help="commit; uncommitted changes, or the last commit, if none is given")
    parser.add_argument("--record", type=Path, metavar="JUNIT", help="record the seconds of a whole run, print nothing")
    arguments = parser.parse_args()
    root = Path(__file__).parents[1]
    if arguments.record is not None:
        SECONDS.write_text(json.dumps(seconds_of(arguments.record, root), indent=1) + "\n", encoding="utf-8")
        return 0
    try:
        changed = arguments.files or changed_files(root, arguments.base)
    except subprocess.CalledProcessError as error:
        return error.returncode
    tests = reaching(Imports(root), changed)
    smoke = SMOKE if any(path.startswith((f"{PACKAGE}/", "registry/")) for path in changed) else ()
    found, left = chosen(tests, json.loads(SECONDS.read_text("utf-8")), smoke)
    for path in found:
        print(path)
    if left:
        print(f"{left} files farther away are left to ./dev test", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
