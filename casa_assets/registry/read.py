"""Read YAML files into documents and frozen records, those of the project in use laid over those of the package.

Tables (a file that maps ids to rows) are joined key by key. A file that is one thing, such as a plan, is taken whole
from the topmost layer that has it.

Unknown keys and keys that occur twice are errors. Parsing all files of registry/ takes a second, so the values of a
file are kept as JSON in the cache folder, under the digest of its text. The line numbers of the values are kept too;
they are read only for an error message or a file that is laid over another.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from casa_assets.core.system import cache_dir, keep_json, kept_json
from casa_assets.errors import RegistryError
from casa_assets.model.record import Record
from casa_assets.model.registry.document import Document, KeyPath, expected_one_of, fields_at
from casa_assets.model.registry.rows import Project
from casa_assets.projects import SETTINGS, layers, project_folder, read_once
from casa_assets.registry.project_files import check_names

KEPT_IN = "registry"  # folder of the cache
R = TypeVar("R", bound=Record)


def read_document(path: Path, name: str = "") -> Document:
    """Parse one file. Raises RegistryError where it is missing, no YAML, or has a key twice.

    `name`: what messages call it; by default the name of the file without its folder.
    """
    called = name or path.name
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise RegistryError(called, 1, "", "a readable file", error.strerror or str(error)) from None
    except ValueError as error:
        raise RegistryError(called, 1, "", "YAML in UTF-8", str(error)) from None
    return parse_document(text, called)


def parse_document(text: str, called: str) -> Document:
    """The document that a text is. Raises RegistryError where it is no YAML, or has a key twice.

    `called`: name of its file in messages.
    """
    kept = cache_dir() / KEPT_IN / f"{hashlib.sha256(_parser_digest() + text.encode()).hexdigest()}.json"
    lines_kept = kept.with_suffix(".lines.json")
    known = kept_json(kept)
    if known is not None:
        return Document(called, known, _Lines(text, called, lines_kept))
    value, lines = _parse(text, called)
    keep_json(lines_kept, [[*path, line] for path, line in lines.items()])
    keep_json(kept, value)
    return Document(called, value, lines)


class _Lines(Mapping[KeyPath, int]):
    """Line of each value of a YAML text by its path, read when the first of them is asked for."""

    def __init__(self, text: str, called: str, kept: Path) -> None:
        self._text, self._called, self._kept = text, called, kept

    @cached_property
    def _found(self) -> Mapping[KeyPath, int]:
        known = kept_json(self._kept)
        if known is not None:
            return {tuple(path): line for *path, line in known}
        return _parse(self._text, self._called)[1]

    def __getitem__(self, path: KeyPath) -> int:
        return self._found[path]

    def __iter__(self) -> Iterator[KeyPath]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)


@cache
def _parser_digest() -> bytes:
    return hashlib.sha256(Path(__file__).read_bytes()).digest()


def _parse(text: str, called: str) -> tuple[Any, Mapping[KeyPath, int]]:
    """The value of a YAML text, and the line of each part of it by its path, counted from 1."""
    import yaml  # here, since it is needed only for a text that is not in the cache

    lines: dict[KeyPath, int] = {}
    loader = yaml.SafeLoader("")

    def parse(node: yaml.Node, at: KeyPath) -> Any:
        lines.setdefault(at, node.start_mark.line + 1)
        if isinstance(node, yaml.SequenceNode):
            return [parse(item, (*at, i)) for i, item in enumerate(node.value)]
        if not isinstance(node, yaml.MappingNode):
            return loader.construct_object(node)
        values: dict[str, Any] = {}
        for key, item in node.value:
            name, line = str(key.value), key.start_mark.line + 1
            if name in values:
                raise RegistryError(called, line, ".".join(map(str, (*at, name))), "each key once", f"{name!r} again")
            lines[(*at, name)] = line
            values[name] = parse(item, (*at, name))
        return values

    try:
        try:
            root = yaml.compose(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # libyaml, if there
        except yaml.YAMLError:  # again in Python, whose messages are better than libyaml's
            root = yaml.compose(text, Loader=yaml.SafeLoader)
        return (parse(root, ()) if root else {}), lines
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise RegistryError(called, line, "", "YAML", f"what it cannot read: {error.problem}") from None
    except (yaml.YAMLError, ValueError) as error:
        raise RegistryError(called, 1, "", "YAML in UTF-8", str(error)) from None


def read_record(kind: type[R], row: Any, document: Document, path: KeyPath, **given: Any) -> R:
    """One validated record from a row of a file; `given` are fields that the row does not state."""
    if not isinstance(row, dict):
        raise document.fault(path, "a mapping", repr(row))
    for name in row.keys() & given.keys():
        raise document.fault((*path, name), f"no {name}: the key of the row is its {name}", repr(row[name]))
    try:
        return kind.model_validate({**row, **given})
    except ValidationError as error:
        # A misspelt name is reported as unknown and as missing: the former is more helpful.
        first = next((e for e in error.errors() if e["type"] == "extra_forbidden"), error.errors()[0])
        at = (*path, *first["loc"])
        if first["type"] == "extra_forbidden":
            got = str(first["loc"][-1])
            raise document.fault(at, expected_one_of(fields_at(kind, first["loc"][:-1]), got), repr(got)) from None
        got = "nothing" if first["type"] == "missing" else repr(first["input"])[:80]
        raise document.fault(at, first["msg"].removeprefix("Input should be "), got) from None


def read_table(kind: type[R], document: Document, key: str = "id") -> dict[str, R]:
    """Records of a file that maps ids to rows."""
    if not isinstance(document.value, dict):
        raise document.fault((), "a mapping of ids to rows", type(document.value).__name__)
    return {name: read_record(kind, row, document, (name,), **{key: name}) for name, row in document.value.items()}


def read_table_file(name: str, root: Path | None = None) -> Document:
    """A table of all layers, such as `categories.yaml` or `families/hob.yaml`; a layer need not have it.

    `root`: the only folder to read; None reads the package's and the project's. Raises RegistryError: no layer has it,
    or one is no YAML.
    """
    return _table(name) if root is None else _read(root / name, name, in_project=False)


def read_topmost(name: str, below: Path | None = None) -> Document:
    """A file that is one thing, such as `plans/galley.yaml`, of the topmost layer that has it. Raises RegistryError.

    `below`: a layer; only those below it are looked at.
    """
    folders = layers() if below is None else layers()[: layers().index(below)]
    found = [folder for folder in folders if (folder / name).is_file()] or [layers()[0]]
    return _read(found[-1] / name, name, in_project=found[-1] == project_folder())


def stated_in(name: str, root: Path | None = None) -> tuple[Path, ...]:
    """The files that state a table or a thing, of the lowest layer first."""
    places = layers() if root is None else (root,)
    return tuple(place / name for place in places if (place / name).is_file())


def names_in(folder: str, root: Path | None = None) -> tuple[str, ...]:
    """Stems of the YAML files in a folder of any layer, sorted."""
    places = layers() if root is None else (root,)
    return tuple(sorted({path.stem for place in places for path in (place / folder).glob("*.yaml")}))


@read_once
def _table(name: str) -> Document:
    found = [folder for folder in layers() if (folder / name).is_file()] or [layers()[0]]
    lowest, *above = (_read(folder / name, name, in_project=folder == project_folder()) for folder in found)
    for document in above:
        lowest = lowest.overlaid(document)
    return lowest


def _read(path: Path, name: str, *, in_project: bool) -> Document:
    """A file, under the name that messages give it: its path for a project, otherwise that below registry/."""
    return read_document(path, str(path) if in_project else name)


PACKAGE = "casa-assets"  # where what is of no project comes from


@read_once
def load_project() -> tuple[Project, Document] | None:
    """The project in use and its document; None if no project is in use.

    Raises RegistryError: its `casa.yaml` is wrong, or a file has nearly the name of one that would be read.
    """
    folder = project_folder()
    if folder is None:
        return None
    check_names(folder)
    path = folder / SETTINGS
    document = read_document(path, str(path))
    return read_record(Project, document.value, document, ()), document


def origin_of_row(table: str, *path: str) -> str:
    """Where the row of a table comes from, or has been changed last: see `origin`."""
    return origin(read_table_file(table).file_of(path))


def origin(file: str) -> str:
    """Where a thing comes from, by the name of the file that states it: the name of the project, or of this package."""
    loaded = load_project()
    return loaded[0].name if loaded is not None and file.startswith(f"{project_folder()}/") else PACKAGE
