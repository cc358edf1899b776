"""Read YAML files into documents and frozen records; unknown keys and keys that occur twice are errors."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import yaml
from pydantic import ValidationError

from casa_assets.errors import RegistryError
from casa_assets.model.record import Record
from casa_assets.model.registry.document import Document, KeyPath
from casa_assets.model.registry.fields import expected_one_of, fields_at

YAML_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml, where PyYAML has it
R = TypeVar("R", bound=Record)


def read_document(path: Path, name: str = "") -> Document:
    """Parse one file. Raises RegistryError where it is missing, no YAML, or has a key twice.

    Args:
        name: what messages call it; by default the name of the file without its folder.
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

    Args:
        called: name of its file in messages.
    """
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
            root = yaml.compose(text, Loader=YAML_LOADER)
        except yaml.YAMLError:  # again in Python, whose messages are better than libyaml's
            root = yaml.compose(text, Loader=yaml.SafeLoader)
        value = parse(root, ()) if root else {}
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        raise RegistryError(called, line, "", "YAML", f"what it cannot read: {error.problem}") from None
    except (yaml.YAMLError, ValueError) as error:
        raise RegistryError(called, 1, "", "YAML in UTF-8", str(error)) from None
    return Document(called, value, MappingProxyType(lines))


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
