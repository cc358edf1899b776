"""Keys of content: which families, objects, textures, plans and styles are no longer those whose tests last passed.

A test that builds all presets of all families fails for a family only where that family, or the test, has changed. Such
a test names the subject of each row by a mark, with the parameters of the row in braces:

    @pytest.mark.content("family", "{family}")

A file of tests that takes long, about one package, names it:

    pytestmark = pytest.mark.content("code", "ingest.collision", keep=0)

`./dev test` runs the rows whose key differs from the one in content_keys.json, and some of the others as
representatives, none of those with `keep=0`; `./dev certify` runs all. Both record the keys where everything has
passed.

The key of a subject is a digest of the modules that make it, with all that they import, and of what the registry states
about it. That of a file of tests is a digest of its text, of what it imports of tests/, and of the modules by which it
judges. Versions of packages and of Python have no part in either: the keys are the same on every machine.

`python -m tests.content_keys` lists what has changed; with `--write` it records the keys.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import pytest

from casa_assets import registry
from casa_assets.asset.assemble import Family
from casa_assets.cache.cache_key import SHOWN, digest_of, reach
from casa_assets.cache.code_index import PACKAGE, is_ours, package_files, package_root, scan, target
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.rows import Surface
from casa_assets.projects import read_once
from casa_assets.registry.families import LOOK_RULES, family, family_names, object_family, object_files, object_names
from casa_assets.registry.kitchens import load_plan, load_style, plan_names, style_names
from casa_assets.registry.plugins.families import FORMS, MODELS
from casa_assets.registry.plugins.textures import texture_kinds
from casa_assets.registry.read import read_table_file
from casa_assets.textures.run.recipes import every_recipe, find_recipe, recipes

ROOT = Path(__file__).parents[1]
RECORDED = Path(__file__).with_name("content_keys.json")
MARK = "content"
# How a file of tests names a package.
CODE = re.compile(r'mark\.content\("code", "([\w.]+)"')
# Rows of a test that run even so, where its mark does not say how many.
KEPT_ROWS = 3
# All of a kind at once, such as `style/all`.
ALL = "all"
# What makes subjects, or knows all of them: a file of tests that imports it does not hang on all that it reaches.
MAKERS = tuple(
    f"{PACKAGE}.{name}"
    for name in ("api", "asset", "cli", "ext", "families", "kitchenware", "layouts", "registry", "textures")
)
# What is below these and yet judges pictures.
JUDGES = (f"{PACKAGE}.textures.distance", f"{PACKAGE}.textures.check")
# What every member of a family, or of a form of objects, goes through.
MEMBERS_PASS = (f"{PACKAGE}.asset.assemble", f"{PACKAGE}.asset.sampling")
PAINTS = f"{PACKAGE}.textures.canvas"
ORDERS_KITCHENS = f"{PACKAGE}.layouts.order.request"


# Subjects -------------------------------------------------------------------------------------------------------------


def _family(name: str) -> str:
    """The code of a family, its presets and rules, its category and contracts, and what parts are made of."""
    found, modules = family(name), _modules_of(MODELS[name])
    rules = [read_table_file(f"families/{name}.yaml").value.get("sample"), read_table_file(LOOK_RULES).value]
    texts = _words(modules) | {MODELS[name].contract or ""}
    contracts = {key: row.digest for key, row in registry.load().contracts.items() if key in texts}
    category = registry.load().fixtures[found.category]
    return digest_of(_code(modules), _presets(name), rules, contracts, _category(category), _materials(modules))


def _object(name: str) -> str:
    """The code of a category's form, its row, and the substances of the pictures that the row names."""
    modules = _modules_of(FORMS[object_family(name).form])
    (file,) = (stem for stem, names in object_files().items() if name in names)
    row = read_table_file(f"objects/{file}.yaml").value[name]
    shown = sorted(set(_texts_in(row)) & every_recipe().keys())
    category = registry.load().categories[name]
    substances = [(skin, every_recipe()[skin].substance) for skin in shown]
    return digest_of(_code(modules), row, substances, _category(category), _materials(modules))


def _texture(name: str) -> str:
    """The code of a recipe's kind, and the recipe."""
    recipe = find_recipe(name)
    kind = texture_kinds()[recipe.kind]
    return digest_of(_code((kind.params.__module__, kind.paint.__module__)), module_digest(PAINTS), recipe.digest)


def _plan(name: str) -> str:
    """The code that lays out kitchens, and the plan."""
    return digest_of(_code((ORDERS_KITCHENS,)), load_plan(name)[0].digest)


def _style(name: str) -> str:
    """A style, and all presets of the families whose members it chooses; of `all`, every style."""
    if name == ALL:
        return digest_of([_style(style) for style in style_names()])
    style = load_style(name)[0]
    chosen = sorted({choice.family for choice in (*style.models.values(), *style.props)})
    return digest_of(style.digest, read_table_file("roles.yaml").value, [(key, _presets(key)) for key in chosen])


def _package(name: str) -> str:
    """The code of a package or module, relative to casa_assets, and the whole registry if it reads it."""
    whole = f"{PACKAGE}.{name}"
    modules = tuple(module for module in sorted(package_files().sources) if f"{module}.".startswith(f"{whole}."))
    if not modules:
        raise LookupError(f'there is no package {whole}, which a mark content("code", ...) names')
    reads = any(scan(module).reads_registry for module in reach(*modules).modules)
    return digest_of(_code(modules), _whole_registry() if reads else "")


@cache
def _whole_registry() -> str:
    files = (path for path in sorted((ROOT / "registry").rglob("*")) if path.is_file())
    return digest_of([(str(p.relative_to(ROOT)), hashlib.sha256(p.read_bytes()).hexdigest()) for p in files])


@cache
def _named_packages() -> list[str]:
    """The packages that marks of files of tests name."""
    texts = (path.read_text("utf-8") for path in sorted(ROOT.glob("tests/**/test_*.py")))
    return sorted({name for text in texts for name in CODE.findall(text)})


KINDS: dict[str, tuple[Callable[[str], str], Callable[[], Iterable[str]]]] = {
    "family": (_family, family_names),
    "object": (_object, object_names),
    "texture": (_texture, lambda: [name for rows in recipes().values() for name in rows]),
    "surface": (
        lambda name: digest_of([_texture(recipe) for recipe in recipes()[Surface(name)]]),
        lambda: [surface.value for surface in Surface],
    ),
    "plan": (_plan, plan_names),
    "style": (_style, lambda: (*style_names(), ALL)),
    "code": (_package, _named_packages),
}


@read_once
def subject_key(subject: str) -> str:
    """First digits of the key of a subject, such as `family/microwave`."""
    kind, _, name = subject.partition("/")
    return KINDS[kind][0](name)[:SHOWN]


@cache
def _code(modules: tuple[str, ...]) -> str:
    """Digest of some modules and of all that they reach."""
    found = reach(*modules)
    data = [(name, hashlib.sha256((package_root() / name).read_bytes()).hexdigest()) for name in found.data]
    return digest_of([(name, module_digest(name)) for name in found.modules], data)


def module_digest(name: str) -> str:
    """Digest of the text of a module."""
    return scan(name).sha256


def _modules_of(model: Family[Any]) -> tuple[str, ...]:
    """The modules that hold the code of a family or form."""
    code = (model.params, model.add_parts, model.sample)
    return tuple(sorted({*MEMBERS_PASS, *(part.__module__ for part in code if part is not None)}))


@cache
def _words(modules: tuple[str, ...]) -> frozenset[str]:
    """Short texts in all that some modules reach: the names of what they use of the registry."""
    return frozenset(word for name in reach(*modules).modules for word in scan(name).words)


@read_once
def _presets(name: str) -> str:
    return digest_of([(preset, params.digest) for preset, params in family(name).presets.items()])


def _category(category: Category) -> list[Any]:
    return [category.digest, registry.load().classes_of(category)]


@read_once
def _materials(modules: tuple[str, ...]) -> str:
    """Digest of all plain finishes and substances, and of the densities that some code names."""
    known, words = registry.load(), _words(modules)
    densities = [row for row in known.densities.items() if row[0] in words or row[0] in known.substances]
    return digest_of(
        [row.digest for row in known.materials.values()], [row.digest for row in known.substances.values()], densities
    )


def _texts_in(value: Any) -> Iterator[str]:
    """All texts in a value of YAML."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        yield from (text for inner in value.values() for text in _texts_in(inner))
    elif isinstance(value, list):
        yield from (text for inner in value for text in _texts_in(inner))


# Files of tests -------------------------------------------------------------------------------------------------------


@cache
def file_key(path: str) -> str:
    """First digits of the key of a file of tests: its text, its helpers, what judges, and the limits that it names."""
    files, waiting = dict[str, PythonText](), [path]
    while waiting:
        name = waiting.pop()
        if name not in files:
            files[name] = python_text(name)
            waiting += files[name].helpers
    makers = tuple(f"{maker}." for maker in MAKERS)
    every = {module for one in files.values() for module in one.modules}
    judges = {module for module in every if module in JUDGES or not f"{module}.".startswith(makers)}
    named = {text for one in files.values() for text in one.texts}
    limits = sorted(row for row in registry.load().limits.items() if row[0] in named)
    texts = [(name, one.sha256) for name, one in sorted(files.items())]
    return digest_of(texts, _code(tuple(sorted(judges))), limits)[:SHOWN]


class PythonText:
    """What stands in a file of tests/.

    Attributes:
        sha256: of its text. helpers: files of tests/ that it imports. modules: of the package, that it imports.
        texts: its constants.
    """

    def __init__(self, text: str) -> None:
        nodes = list(ast.walk(ast.parse(text)))
        imported = {pair for node in nodes for pair in _imported(node)}
        names = {
            full for origin, name in imported if origin.startswith("tests") for full in (origin, f"{origin}.{name}")
        }
        places = {f"{name.replace('.', '/')}.py" for name in names}
        self.sha256 = hashlib.sha256(text.encode()).hexdigest()
        self.helpers = sorted(place for place in places if (ROOT / place).is_file())
        self.modules = sorted({target(*pair) for pair in imported if is_ours(pair[0]) and pair[0] != PACKAGE})
        self.modules += sorted(f"{PACKAGE}.{name or 'api'}" for origin, name in imported if origin == PACKAGE)
        self.texts = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}


def _imported(node: ast.AST) -> Iterator[tuple[str, str]]:
    """Origin and name of what an import binds; no name for a whole module."""
    if isinstance(node, ast.ImportFrom):
        yield from ((node.module or "", alias.name) for alias in node.names)
    elif isinstance(node, ast.Import):
        yield from ((alias.name, "") for alias in node.names)


@cache
def python_text(path: str) -> PythonText:
    """What stands in a file, by its path relative to the checkout."""
    return PythonText((ROOT / path).read_text(encoding="utf-8"))


# Rows -----------------------------------------------------------------------------------------------------------------


def subjects(item: pytest.Item) -> list[str]:
    """The subjects of a row of a test; empty where it is none of content."""
    given = getattr(getattr(item, "callspec", None), "params", {})
    return ["/".join(mark.args).format(**given) for mark in item.iter_markers(MARK)]


def unchanged(
    items: Iterable[pytest.Item], recorded: Mapping[str, str] | None = None, most: int | None = None
) -> list[pytest.Item]:
    """Rows whose subjects and file are those that were recorded, but for the representatives of each test.

    Representatives are spread evenly over the rows of a test: the first is always one.

    Args:
        recorded: key by subject or path; None reads the file.
        most: of a test of which more rows than these have changed, the representatives alone are run, if it has any.
    """
    tests: dict[str, list[pytest.Item]] = {}
    for item in items:
        if item.get_closest_marker(MARK) is not None:
            tests.setdefault(item.nodeid.partition("[")[0], []).append(item)
    known = recorded if recorded is not None else read_recorded() if tests else {}
    found = []
    for test, rows in tests.items():
        stated = [mark.kwargs["keep"] for mark in rows[0].iter_markers(MARK) if "keep" in mark.kwargs]
        count = stated[0] if stated else KEPT_ROWS
        kept = {number * len(rows) // count for number in range(count)}
        others = [row for number, row in enumerate(rows) if number not in kept]
        path = test.partition("::")[0]
        is_old = known.get(path) == file_key(path)
        same = [row for row in others if is_old and all(known.get(s) == subject_key(s) for s in subjects(row))]
        found += others if kept and most is not None and len(others) - len(same) > most else same
    return found


@lru_cache(maxsize=1)
def read_recorded() -> Mapping[str, str]:
    """The recorded keys; empty if there are none."""
    found: dict[str, str] = json.loads(RECORDED.read_text(encoding="utf-8")) if RECORDED.is_file() else {}
    return found


def present_keys() -> dict[str, str]:
    """Keys of all subjects and of all files of tests that have such rows."""
    marked = (path for path in sorted(ROOT.glob("tests/**/test_*.py")) if f"mark.{MARK}(" in path.read_text("utf-8"))
    files = {name: file_key(name) for name in (path.relative_to(ROOT).as_posix() for path in marked)}
    names = sorted(f"{kind}/{name}" for kind, (_, every) in KINDS.items() for name in every())
    return files | {name: subject_key(name) for name in names}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m tests.content_keys", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("--write", action="store_true", help="record the keys; all tests of content have passed")
    arguments = parser.parse_args()
    found, before = present_keys(), read_recorded()
    changed = sorted(name for name in found.keys() | before.keys() if found.get(name) != before.get(name))
    if arguments.write:
        RECORDED.write_text(json.dumps(found, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    print("\n".join(changed))
    print(f"{len(changed)} of {len(found)} differ from those {'before' if arguments.write else 'recorded'}")


if __name__ == "__main__":
    main()
