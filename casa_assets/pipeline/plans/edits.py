"""Faults of plans, mends of them, and the edits that mends make: in the value of a file, and in its text.

A text keeps its comments, order and layout: it is parsed for the places of its parts, and characters are exchanged
there. What comes out is parsed again: where it is not what the edit asks for, the whole value is written anew, without
comments. The rows of a plan may be written by id or as a list, its units in short forms.
"""

from __future__ import annotations

import copy
import difflib
import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import yaml

from casa_assets.errors import OutputError, RegistryError
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.registry.document import KeyPath
from casa_assets.registry.read import parse_document

PLAIN = re.compile(r"[A-Za-z_][\w./-]*( [\w./()-]+)*")
NOT_PLAIN = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"}
WIDE = 110  # longest line that a collection is written in
NEAR = 0.6  # least similarity of a misspelt name, as difflib counts it


class EditKind(StrEnum):
    """What an edit does.

    REPLACE: the value at a pointer, or a key that is not there yet. RENAME: the last key of a pointer. REMOVE: a key
    with its value, or an item. INSERT: an item into a list, before the one at the pointer.
    """

    REPLACE = "replace"
    RENAME = "rename"
    REMOVE = "remove"
    INSERT = "insert"


@dataclass(frozen=True)
class Edit:
    """One change of a file.

    Attributes:
        pointer: of what is changed; of INSERT: of what is new.
        value: the new value; of RENAME the new key; of REMOVE None.
    """

    kind: EditKind
    pointer: KeyPath
    value: Any = None


@dataclass(frozen=True)
class Mend:
    """What would mend a fault: a sentence for people, in the imperative, and edits, one after the other."""

    sentence: str
    edits: tuple[Edit, ...] = ()


@dataclass(frozen=True)
class Fault:
    """Something that is wrong with a plan.

    Attributes:
        pointer: of what is wrong, as the file has it.
        expected, got: as in a RegistryError. mend: None where nothing sensible is near.
        line: where the pointer does not say it, counted from 1; else 0.
    """

    pointer: KeyPath
    expected: str
    got: str
    mend: Mend | None = None
    line: int = 0


def put(pointer: KeyPath, value: Any) -> Edit:
    """The edit that puts a value at a pointer, in the place of what may stand there."""
    return Edit(EditKind.REPLACE, pointer, value)


def renamed(pointer: KeyPath, name: str) -> Edit:
    """The edit that calls the last key of a pointer something else."""
    return Edit(EditKind.RENAME, pointer, name)


def removed(pointer: KeyPath) -> Edit:
    """The edit that takes a key or an item out."""
    return Edit(EditKind.REMOVE, pointer)


def inserted(pointer: KeyPath, item: Any) -> Edit:
    """The edit that puts an item before the one at a pointer."""
    return Edit(EditKind.INSERT, pointer, item)


# Parts of plans --------------------------------------------------------------------------------------------------


def value_at(value: Any, pointer: Sequence[str | int]) -> Any:
    """What stands at a pointer; None where nothing does."""
    for step in pointer:
        if isinstance(value, dict):
            value = value.get(step)
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
        else:
            return None
    return value


def row_at(plan: Any, table: str, name: str) -> KeyPath:
    """Pointer of the row of that id, in a mapping of ids or a list."""
    rows = plan.get(table)
    if isinstance(rows, list):
        found = [k for k, row in enumerate(rows) if isinstance(row, dict) and row.get("id") == name]
        return (table, found[0]) if found else (table,)
    return (table, name)


def unit_at(plan: Any, run: str, row: str, index: int) -> KeyPath:
    """Pointer of a unit of a row, `base` or `upper`."""
    return (*row_at(plan, "runs", run), row, index)


def place_of(plan: Plan, name: str) -> tuple[str, str, int] | None:
    """Run, row and number of a unit; None of what the layout adds."""
    rows = ((run.id, row, units) for run in plan.runs for row, units in (("base", run.base), ("upper", run.upper)))
    return next(((run, row, k) for run, row, units in rows for k, u in enumerate(units) if u.id == name), None)


def unit_edit(plan: Any, at: KeyPath, key: str, value: Any) -> Edit:
    """Set a field of a unit that is written `- doors`, `- doors: 0.6` or `- doors: {width: 0.6}`."""
    unit = value_at(plan, at)
    if not isinstance(unit, dict):
        return put(at, {unit: value if key == "width" else {key: value}})
    kind, inner = next(iter(unit.items()))
    if len(unit) > 1:  # with all its fields in full
        return put((*at, key), value)
    if isinstance(inner, dict):
        return put((*at, kind, key), value)
    both = {key: value} if inner is None else {"width": inner, key: value}
    return put((*at, kind), value if key == "width" else both)


def without_key(plan: Any, at: KeyPath, key: str) -> Edit:
    """Take a field of a unit out that it has, such as its width, so that it has its usual one."""
    unit = value_at(plan, at)
    kind, inner = next(iter(unit.items()))
    if len(unit) > 1:
        return removed((*at, key))
    return removed((*at, kind, key)) if isinstance(inner, dict) and len(inner) > 1 else put(at, kind)


def with_item(plan: Any, at: KeyPath, item: Any, index: int | None = None) -> Edit:
    """Put an item into a list that may not be there yet, at its end or before the one of a number."""
    items = value_at(plan, at)
    if not isinstance(items, list) or not items:
        return put(at, [item])
    return inserted((*at, len(items) if index is None else index), item)


def spelt(word: str) -> str:
    """A word as ids are spelt: small letters, numbers and underscores."""
    parts = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", word.strip())
    return re.sub(r"_+", "_", re.sub(r"[^a-z0-9]+", "_", parts.lower())).strip("_")


def nearest(word: str, known: Iterable[str], least: float = NEAR) -> str | None:
    """The known name that is spelt like a word or most similar to it; None if none is similar enough."""
    names, same = list(known), spelt(word)
    if same in names:
        return same
    return next(iter(difflib.get_close_matches(same, names, n=1, cutoff=least)), None)


# Values and texts ------------------------------------------------------------------------------------------------


def edited_value(value: Any, edit: Edit) -> Any:
    """A copy of a value with an edit made. Raises KeyError, IndexError or TypeError where it has no such place."""
    made = copy.deepcopy(value)
    if not edit.pointer:
        return copy.deepcopy(edit.value)
    here, key = made, edit.pointer[-1]
    for step in edit.pointer[:-1]:
        here = here[step]
    if edit.kind is EditKind.REMOVE:
        del here[key]
    elif edit.kind is EditKind.INSERT:
        here.insert(key, copy.deepcopy(edit.value))
    elif edit.kind is EditKind.RENAME:
        items = [(edit.value if k == key else k, v) for k, v in here.items()]
        here.clear()
        here.update(items)
    else:
        here[key] = copy.deepcopy(edit.value)
    return made


def edited(text: str, edit: Edit) -> str:
    """The text with an edit made. Raises RegistryError where the text is no YAML, KeyError and so on as above."""
    wanted = edited_value(parse_document(text, "").value, edit)
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    if edit.pointer and root is not None:
        try:
            made = _edited(text, root, edit)
            if parse_document(made, "").value == wanted:
                return made
        except (RegistryError, KeyError, IndexError, TypeError):
            pass
    return block_text(wanted)


def _edited(text: str, root: yaml.Node, edit: Edit) -> str:
    path, key = edit.pointer[:-1], edit.pointer[-1]
    parent = root
    for step in path:
        parent = _child(parent, step)[1]
    if edit.kind is EditKind.INSERT:
        return _insert(text, parent, int(key), edit.value)
    is_new = isinstance(parent, yaml.MappingNode) and not any(str(k.value) == str(key) for k, _ in parent.value)
    if edit.kind is EditKind.REPLACE and (is_new or isinstance(parent, yaml.ScalarNode)):
        return _add(text, parent, str(key), edit.value)
    at, node = _child(parent, key)
    if edit.kind is EditKind.RENAME:
        assert at is not None, "only a key is renamed"
        return text[: at.start_mark.index] + _key_text(str(edit.value)) + text[at.end_mark.index :]
    if edit.kind is EditKind.REMOVE:
        return _remove(text, parent, key)
    return _replace(text, parent, at, node, edit.value)


def _child(parent: yaml.Node, step: str | int) -> tuple[yaml.Node | None, yaml.Node]:
    """The key node, None in a list, and the value node of a part."""
    if isinstance(parent, yaml.MappingNode):
        found = next(((k, v) for k, v in parent.value if str(k.value) == str(step)), None)
        if found is None:
            raise KeyError(step)
        return found
    assert isinstance(parent, yaml.SequenceNode)
    return None, parent.value[int(step)]


def _end(node: yaml.Node) -> int:
    """Where what is written of a node ends; YAML lets collections in block form end where the next thing begins."""
    if isinstance(node, yaml.ScalarNode) or _is_flow(node) or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    return _end(last[1] if isinstance(node, yaml.MappingNode) else last)


def _is_flow(node: yaml.Node) -> bool:
    """True of a collection in brackets."""
    return isinstance(node, yaml.CollectionNode) and bool(node.flow_style)


def _line_start(text: str, index: int) -> int:
    return text.rfind("\n", 0, index) + 1


def _line_end(text: str, index: int) -> int:
    """Index behind the end of the line in which `index` lies."""
    end = text.find("\n", index)
    return len(text) if end < 0 else end + 1


def _replace(text: str, parent: yaml.Node, key: yaml.Node | None, node: yaml.Node, value: Any) -> str:
    start, end = node.start_mark.index, max(_end(node), node.start_mark.index)
    if key is None or _is_flow(parent) or (isinstance(node, yaml.ScalarNode) and not isinstance(value, dict | list)):
        gap = " " if start and text[start - 1] in ":-" else ""
        is_item = key is None and not _is_flow(parent)
        return text[:start] + gap + (item_text(value) if is_item else flow_text(value)) + text[end:]
    head = text.index(":", key.end_mark.index) + 1
    return text[:head] + _behind_key(value, parent.start_mark.column) + text[max(end, head) :]


def _behind_key(value: Any, column: int) -> str:
    """A value as it is written behind a key and its colon: in the line where that is short, else in lines below."""
    line = flow_text(value)
    is_deep = isinstance(value, dict | list) and any(isinstance(v, dict | list) for v in _items(value))
    if not isinstance(value, dict | list) or not value or (not is_deep and len(line) + column < WIDE):
        return f" {line}"
    return "\n" + block_text(value, column + 2).rstrip("\n")


def _items(value: Any) -> list[Any]:
    return list(value.values()) if isinstance(value, dict) else list(value)


def _add(text: str, parent: yaml.Node, key: str, value: Any) -> str:
    if isinstance(parent, yaml.ScalarNode):  # a key with nothing behind it
        start = parent.start_mark.index
        return text[:start] + " " + flow_text({key: value}) + text[parent.end_mark.index :]
    if _is_flow(parent) or not parent.value:
        end = parent.end_mark.index - 1
        comma = ", " if parent.value else ""
        return f"{text[:end].rstrip()}{comma}{_key_text(key)}: {flow_text(value)}{text[end:]}"
    column = parent.value[0][0].start_mark.column
    at = _line_end(text, _end(parent))
    head = text[:at] if text[:at].endswith("\n") else text[:at] + "\n"
    return f"{head}{' ' * column}{_key_text(key)}:{_behind_key(value, column)}\n{text[at:]}"


def _insert(text: str, parent: yaml.Node, index: int, value: Any) -> str:
    items = parent.value
    if _is_flow(parent) or not items:
        line = flow_text(value)
        if index < len(items):
            start = items[index].start_mark.index
            return f"{text[:start]}{line}, {text[start:]}"
        end = parent.end_mark.index - 1
        return f"{text[:end].rstrip()}{', ' if items else ''}{line}{text[end:]}"
    column = parent.start_mark.column
    at = _line_start(text, items[index].start_mark.index) if index < len(items) else _line_end(text, _end(items[-1]))
    head = text[:at] if not at or text[:at].endswith("\n") else text[:at] + "\n"
    return f"{head}{' ' * column}- {item_text(value)}\n{text[at:]}"


def _remove(text: str, parent: yaml.Node, key: str | int) -> str:
    is_map = isinstance(parent, yaml.MappingNode)
    rows = [(k, v) for k, v in parent.value] if is_map else [(v, v) for v in parent.value]
    n = next(i for i, (k, _) in enumerate(rows) if (str(k.value) == str(key) if is_map else i == key))
    start, end = rows[n][0].start_mark.index, _end(rows[n][1])
    if len(rows) == 1:
        return text[: parent.start_mark.index] + ("{}" if is_map else "[]") + text[_end(parent) :]
    if _is_flow(parent):
        if n + 1 < len(rows):
            return text[:start] + text[rows[n + 1][0].start_mark.index :]
        return text[: _end(rows[n - 1][1])] + text[end:]
    if is_map and text[_line_start(text, start) : start].strip() and n + 1 < len(rows):  # the first of a list's item
        return text[:start] + text[rows[n + 1][0].start_mark.index :]
    return text[: _line_start(text, start)] + text[_line_end(text, end) :]


def flow_text(value: Any) -> str:
    """A value in one line of YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key_text(str(k))}: {flow_text(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow_text(v) for v in value) + "]"
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    if isinstance(value, float):
        return (
            ".nan" if math.isnan(value) else f"{value:.10g}" if math.isfinite(value) else f"{value}".replace("i", ".i")
        )
    if isinstance(value, int):
        return str(value)
    text = str(value)
    return text if PLAIN.fullmatch(text) and text.lower() not in NOT_PLAIN else json.dumps(text, ensure_ascii=False)


def _key_text(key: str) -> str:
    return key if PLAIN.fullmatch(key) else json.dumps(key, ensure_ascii=False)


def item_text(value: Any) -> str:
    """An item of a list in block form: `drawers: 0.6` for a mapping of one key."""
    if isinstance(value, dict) and len(value) == 1:
        key, row = next(iter(value.items()))
        return f"{_key_text(str(key))}: {flow_text(row)}"
    return flow_text(value)


def block_text(value: Any, column: int = 0) -> str:
    """A value in lines of YAML, each entry one line where it is short enough."""
    margin = " " * column
    if isinstance(value, dict) and value:
        return "".join(f"{margin}{_key_text(str(k))}:{_behind_key(v, column)}\n" for k, v in value.items())
    if isinstance(value, list | tuple) and value:
        return "".join(f"{margin}- {item_text(v)}\n" for v in value)
    return f"{margin}{flow_text(value)}\n"


def read_plan_text(path: Path) -> str:
    """The text of a file. Raises RegistryError where it is not UTF-8 or cannot be read."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise RegistryError(path.name, 1, "", "YAML in UTF-8", str(error)) from None
    except OSError as error:
        raise RegistryError(path.name, 1, "", "a readable file", error.strerror or str(error)) from None


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet. Raises OutputError where it is."""
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise OutputError(str(path), "is there already; name another file") from None
