"""Compute cache keys: the key of a function is a digest of all code and data that it can reach."""

from __future__ import annotations

import ast
import hashlib
import json
import symtable
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

from casa_assets.cache.code_index import (
    PACKAGE,
    TEMPLATES,
    Scan,
    Stamp,
    installed,
    is_ours,
    kept_at,
    names_in_text,
    package_files,
    package_root,
    reads_registry,
    scan,
    stamp_of,
    target,
    versions_of_package,
)
from casa_assets.checks.simready_python import versions_elsewhere
from casa_assets.core.system import keep_json, kept_json
from casa_assets.projects import data_root, project_folder, read_once
from casa_assets.registry.plugins.load import load_plugins
from casa_assets.registry.project_files import files_of
from casa_assets.registry.read import stated_in

# Code parts -----------------------------------------------------------------------------------------------------------
# Parsing a large module takes 10 ms, and a run that has nothing to do asks about dozens of functions: what was found
# is kept in the cache folder, under the digest of the module.


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
    """Return the part of a module that a top-level function or class uses. Raises LookupError if it does not exist."""
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
        else:
            is_docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
            is_typing = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
            always += [] if is_docstring or is_typing else [node]
    return defined, imported, always


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
    """Return the module-level names that a top-level statement uses, without local variables of the same names."""
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


# Cache key ------------------------------------------------------------------------------------------------------------
# A kept result (a texture, a built asset, a scene, a picture, a report, an entry of a library) is kept under a key. The
# key of the function that made it is a sha256 over
#
# - the function itself and what it uses of its own module, without comments;
# - every module of this package that those names lead to by import, and on from there: `import` at the top of a module
#   or inside a function, and modules named in text as `package.module:function`, which are loaded by that name. What is
#   imported under TYPE_CHECKING is not there when the program runs, and is left out;
# - the `__init__.py` of each package on the way, but for that of `casa_assets` itself;
# - the files of registry/, and of the project in use, that those modules can read: a module that calls `data_root` or a
#   function of `registry/read.py` reads the files and folders that it names in text; and other files of the package,
#   such as style sheets, that they name;
# - the installed versions of all third-party packages that those modules import, and of those that another Python has
#   where SimReady's validator runs there.
#
# Nobody raises a number. The rule may count too much, never too little: where a module is reached, all of it counts.
# What a function is given as an argument is not covered and has to be put into the key too, by value (see
# `digest_of`).

# What reaches this module runs the checks of plug-ins.
CHECKS_OF_PLUGINS = f"{PACKAGE}.registry.plugins.checks"
# What reaches this module validates by SimReady, in another Python where this one has no SimReady.
RULES_OF_SIMREADY = f"{PACKAGE}.checks.simready"
# A function, class or module, or the name of one such as `casa_assets.ingest.run.steps:work`; what is named is
# not imported.
CodeRef = Callable[..., Any] | ModuleType | str
# Hex digits of a key where it is shown to a person.
SHOWN = 12
# Packages that only decide where jobs run: results are the same with another version, and without them.
_ENGINES = frozenset({"ray"})


@dataclass(frozen=True)
class Reach:
    """Modules, packages and data files that a piece of code can reach.

    Attributes:
        modules: names of modules of this package. packages: top-level names of third-party packages.
        registry: files of registry/, relative to it. data: other files of this package, relative to it.
        own: address and digest of each function itself, with what it uses of its module.
    """

    modules: tuple[str, ...]
    packages: tuple[str, ...]
    registry: tuple[str, ...]
    data: tuple[str, ...] = ()
    own: tuple[str, ...] = ()

    @property
    def versions(self) -> dict[str, str]:
        """Version of each distribution that provides one of the packages, by its name, sorted."""
        found: dict[str, str] = {}
        for package in self.packages:
            found |= versions_of_package(package) or {package: "absent"}
        if RULES_OF_SIMREADY in self.modules:
            found |= versions_elsewhere()
        return dict(sorted(found.items()))


def key_of(*made_by: CodeRef) -> str:
    """The key of functions, classes or modules of this package: 64 hex digits, the same on every machine.

    Args:
        made_by: a function or class counts with what it uses, a module with all that it holds.
    """
    return _key(_addresses(made_by))


def digest_of(*parts: Any) -> str:
    """sha256 of values that JSON can hold: keys, digests, numbers and text together are the key of a result."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, allow_nan=False).encode()).hexdigest()


def reach(*made_by: CodeRef) -> Reach:
    """Collect everything that the key of functions, classes or modules is made from."""
    return _reach(_addresses(made_by))


def versions_of(steps: Mapping[str, CodeRef | tuple[CodeRef, ...]]) -> dict[str, str]:
    """Steps of a producer as `stage:<name>` with the first digits of its key, and `tool:<package>` with its version."""
    found: dict[str, str] = {}
    for name, made in steps.items():
        every = made if isinstance(made, tuple) else (made,)
        found[f"stage:{name}"] = key_of(*every)[:SHOWN]
        found |= {f"tool:{package}": number for package, number in reach(*every).versions.items()}
    return dict(sorted(found.items()))


def modules_holding(value: object, within: str) -> tuple[ModuleType, ...]:
    """The modules below a package that hold a value as a global, without the packages that pass it on.

    Args:
        value: found by identity, such as a Family. within: name of a package whose modules have been imported.
    """
    found = [
        module
        for name, module in sorted(sys.modules.items())
        if name.startswith(f"{within}.")
        and not hasattr(module, "__path__")
        and id(value) in map(id, vars(module).values())
    ]
    if not found:
        raise LookupError(f"no module below {within} holds {value!r} under a name of its own")
    return tuple(found)


@read_once
def _key(addresses: tuple[tuple[str, str], ...]) -> str:
    found = _reach(addresses)
    return digest_of(
        list(found.own),
        [(name, scan(name).sha256) for name in found.modules],
        [(name, _registry_digest(name)) for name in found.registry],
        [(name, _file_digest(package_root() / name)) for name in found.data],
        found.versions,
        # No module says which plug-ins there are. Families and textures have the digests of theirs in their keys.
        *(checks_of_plugins() if CHECKS_OF_PLUGINS in found.modules else ()),
    )


@read_once
def state_of_everything() -> str:
    """Digest of the stamps of all files of the program, its registry and the project, and of what is installed.

    It changes with anything that a key could be made from, and often without: a key found before is valid as long as
    it does not.
    """
    plugins = [(one.plugin.name, one.digest) for one in load_plugins()]
    return digest_of(
        str(package_root()), package_files().stamps, _registry_stamps(), plugins, installed(), versions_elsewhere()
    )


@read_once
def last_change_ns() -> int:
    """When a file of the program, its registry or the project last changed, as `state_of_everything` sees them."""
    stamps = (*package_files().stamps.values(), *(stamp for _, stamp in _registry_stamps()))
    return max(max(stamp[:2]) for stamp in stamps)


@read_once
def _registry_stamps() -> list[tuple[str, Stamp]]:
    return [(str(path), stamp_of(path.stat())) for name in _registry() for path in stated_in(name)]


def checks_of_plugins() -> tuple[str, ...]:
    """Digests of the plug-ins that define checks; empty without such plug-ins."""
    return tuple(one.digest for one in load_plugins() if one.plugin.checks)


@read_once
def _reach(addresses: tuple[tuple[str, str], ...]) -> Reach:
    parts = {f"{module}:{name}": part(module, name) for module, name in addresses if name}
    imports = {name for one in parts.values() for name in one.imports}
    starts = {module for module, name in addresses if not name} | {name for name in imports if is_ours(name)}
    modules = _closure(starts, (module for module, _ in addresses))
    packages = {name.partition(".")[0] for name in (*imports, *(n for m in modules for n in scan(m).outside))}
    texts: list[Scan | Part] = [*parts.values(), *map(scan, modules)]
    return Reach(
        tuple(modules),
        tuple(sorted(name for name in packages - sys.stdlib_module_names - _ENGINES if not is_ours(name))),
        _registry_files(texts),
        _data_files(texts),
        tuple(f"{address} {one.sha256}" for address, one in parts.items()),
    )


def _addresses(made_by: Iterable[CodeRef]) -> tuple[tuple[str, str], ...]:
    """Name of the module and of the top-level function or class in it, each once; no name for a whole module."""
    found: dict[tuple[str, str], None] = {}
    for made in made_by:
        if isinstance(made, str):
            module, _, name = made.partition(":")
        elif isinstance(made, ModuleType):
            module, name = made.__name__, ""
        else:
            module, name = made.__module__, made.__qualname__.partition(".")[0]
            if "<lambda>" in made.__qualname__:
                raise ValueError(f"a lambda of {module} has no name to find its source by; write a function")
        found[module, name] = None
    return tuple(found)


def _closure(starts: Iterable[str], homes: Iterable[str]) -> list[str]:
    """Return the modules reachable from `starts`, themselves included, and the packages that contain these and `homes`.

    A package that is only passed on the way to a module counts with its text, but not with its imports: it may create
    objects when it is imported, but passes none of them to code that imports a module below it.
    """
    seen: set[str] = set()
    waiting = list(starts)
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            waiting += scan(name).modules
    found = set(seen)
    for name in (*seen, *homes):
        # Not the package on top, which holds the version and takes no part in any result.
        while (name := name.rpartition(".")[0]) not in ("", PACKAGE):
            found.add(name)
    return sorted(found)


def _data_files(texts: Iterable[Scan | Part]) -> tuple[str, ...]:
    """Return files of the package that are not Python, such as style sheets, and that some code names in text.

    Files named by a template count too: the page that it extends, and the macros, styles and scripts that it includes.
    """
    paths = package_files().data
    waiting = {path for text in texts for name in text.words for path in paths.get(name, ())}
    found: set[str] = set()
    while waiting:
        path = waiting.pop()
        found.add(path)
        if TEMPLATES in Path(path).parts and path.endswith(".html"):
            words = names_in_text((package_root() / path).read_text(encoding="utf-8"))
            waiting |= {inner for name in words for inner in paths.get(name, ())} - found
    return tuple(sorted(found))


def _registry_files(texts: Iterable[Scan | Part]) -> tuple[str, ...]:
    """Files of registry/ that some code can read: those that code which calls `data_root` names in text."""
    words = {word for text in texts if text.reads_registry for word in text.words}
    return tuple(p for p in _registry() if p.partition("/")[0] in words or p.rpartition(".")[0] in words)


@read_once
def _registry() -> tuple[str, ...]:
    """Every file of registry/, and those of the project in use that are laid over it; relative to these, sorted."""
    found = {path.relative_to(data_root()).as_posix() for path in data_root().rglob("*") if path.is_file()}
    project = project_folder()
    if project is not None:
        found |= {path.relative_to(project).as_posix() for path in files_of(project)}
    return tuple(sorted(found))


@read_once
def _registry_digest(name: str) -> str:
    """Digest of a file of registry/, and of what a project lays over it."""
    lowest, *above = (hashlib.sha256(path.read_bytes()).hexdigest() for path in stated_in(name))
    return digest_of(lowest, *above) if above else lowest


@cache
def _file_digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
