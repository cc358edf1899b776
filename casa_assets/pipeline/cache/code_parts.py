"""Find what a top-level function or class of a module uses of its own module, and what that imports.

Parsing a large module takes 10 ms, and a run that has nothing to do asks about dozens of functions: what was found is
kept in the cache folder, under the digest of the module.
"""

from __future__ import annotations

import ast
import hashlib
import symtable
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from casa_assets.core.cache_folder import keep_json, kept_json
from casa_assets.pipeline.cache.code_index import (
    PACKAGE,
    kept_at,
    names_in_text,
    package_files,
    package_root,
    reads_registry,
    scan,
    target,
)


@dataclass(frozen=True)
class Part:
    """A function or class with all that it uses of its module.

    Attributes:
        sha256: of its text, without comments. imports: modules that it imports or names in text.
        words: its short texts, among which are names of files. reads_registry: it reads files of registry/, those that
            it names.
    """

    sha256: str
    imports: tuple[str, ...]
    words: tuple[str, ...]
    reads_registry: bool


def part(module: str, name: str) -> Part:
    """The part of a module that a function or class at its top level uses. Raises LookupError if there is none."""
    kept, address, digest = _kept(), f"{module}:{name}", scan(module).sha256
    row = kept.get(address)
    if row is None or row[0] != digest:
        text, imports = part_of(module, name)
        own = hashlib.sha256(text.encode()).hexdigest()
        row = kept[address] = [digest, own, sorted(imports), sorted(names_in_text(text)), reads_registry(text)]
        keep_json(_place(), kept)
    return Part(row[1], tuple(row[2]), tuple(row[3]), bool(row[4]))


def _place() -> Path:
    return kept_at("parts", str(package_root()), *package_files().sources)


@lru_cache(maxsize=1)
def _kept() -> dict[str, Any]:
    return kept_json(_place()) or {}


def part_of(module: str, name: str) -> tuple[str, set[str]]:
    """A top-level definition with all that it uses of its module, as text, and the modules that this imports."""
    tree = _tree(module)
    defined, imported, always = _bindings(tree)
    if name not in defined:
        raise LookupError(f"{module} defines no {name} at its top level")
    seen: set[str] = set()
    waiting = [name]
    nodes: list[ast.stmt] = list(always)
    imports: set[str] = {n for node in always for n in _imports_inside(node)}
    for node in always:
        waiting += _names(node)
    while waiting:
        at = waiting.pop()
        if at in seen:
            continue
        seen.add(at)
        imports |= imported.get(at, set())
        for node in defined.get(at, ()):
            nodes.append(node)
            waiting += _globals(module, node)
            imports |= _imports_inside(node)
    ordered = sorted(dict.fromkeys(nodes), key=lambda node: node.lineno)
    return "\n".join(ast.unparse(node) for node in ordered), imports


def _bindings(tree: ast.Module) -> tuple[dict[str, list[ast.stmt]], dict[str, set[str]], list[ast.stmt]]:
    """Statements by the name that they define, modules by the name that they are imported under, other statements."""
    defined: dict[str, list[ast.stmt]] = {}
    imported: dict[str, set[str]] = {}
    always: list[ast.stmt] = []
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            defined.setdefault(node.name, []).append(node)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            for name, module in _imported(node):
                imported.setdefault(name, set()).add(module)
        elif isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = [n.id for target in targets for n in ast.walk(target) if isinstance(n, ast.Name)]
            for name in names:
                defined.setdefault(name, []).append(node)
        elif not _is_inert(node):
            always.append(node)
    return defined, imported, always


def _is_inert(node: ast.stmt) -> bool:
    """A docstring, or a block under TYPE_CHECKING."""
    if isinstance(node, ast.If):
        return isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _imported(node: ast.Import | ast.ImportFrom) -> Iterator[tuple[str, str]]:
    """Names that an import binds, and the modules that they lead to."""
    for alias in node.names:
        if isinstance(node, ast.ImportFrom):
            yield alias.asname or alias.name, target(node.module or "", alias.name)
        else:
            yield alias.asname or alias.name.partition(".")[0], alias.name


def _imports_inside(node: ast.AST) -> set[str]:
    """Modules that are imported inside a definition, or loaded by a name in its text."""
    found = {m for n in ast.walk(node) if isinstance(n, ast.Import | ast.ImportFrom) for _, m in _imported(n)}
    texts = [n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)]
    for text in texts:
        name = text.partition(":")[0]
        if name.startswith(f"{PACKAGE}.") and name in package_files().sources:
            found.add(name)
    return found


def _names(node: ast.AST) -> list[str]:
    return [n.id for n in ast.walk(node) if isinstance(n, ast.Name)]


def _globals(module: str, node: ast.stmt) -> list[str]:
    """Names of its module that a top-level statement uses; local variables that are called the same are none."""
    if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return _names(node)
    outer: list[ast.AST] = list(node.decorator_list)
    if isinstance(node, ast.ClassDef):
        outer += [*node.bases, *node.keywords, *(s.annotation for s in ast.walk(node) if isinstance(s, ast.AnnAssign))]
        functions = [n for n in ast.walk(node) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    else:
        functions = [node]
    for function in functions:
        every = (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)
        every = (*every, *(a for a in (function.args.vararg, function.args.kwarg) if a is not None))
        outer += [*function.args.defaults, *(d for d in function.args.kw_defaults if d is not None)]
        outer += [a.annotation for a in every if a.annotation is not None]
        outer += [function.returns] if function.returns is not None else []
        outer += function.decorator_list
    found = {name for part in outer for name in _names(part)}
    waiting = [t for t in _symbols(module).get_children() if t.get_name() == node.name]
    while waiting:
        table = waiting.pop()
        found |= {symbol.get_name() for symbol in table.get_symbols() if symbol.is_global()}
        waiting += table.get_children()
    return sorted(found)


@lru_cache(maxsize=32)
def _tree(module: str) -> ast.Module:
    return ast.parse(_source(module))


@lru_cache(maxsize=32)
def _symbols(module: str) -> symtable.SymbolTable:
    return symtable.symtable(_source(module), module, "exec")


def _source(module: str) -> str:
    return package_files().sources[module].read_text(encoding="utf-8")
