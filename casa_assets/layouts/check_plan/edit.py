"""Edits of YAML files, applied to their values and their texts, and the faults that they correct.

A text keeps its comments, order and layout: it is parsed for the positions of its parts, and characters are replaced
there. The result is parsed again: if it is not what the edit asks for, the whole value is written again, without
comments.
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
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from casa_assets.errors import OutputError, RegistryError
from casa_assets.model.registry.document import KeyPath
from casa_assets.registry.read import parse_document

PLAIN = re.compile(r"[A-Za-z_][\w./-]*( [\w./()-]+)*")
NOT_PLAIN = {"true", "false", "yes", "no", "on", "off", "null", "y", "n"}
WIDE = 110  # longest line that a collection is written in
NEAR = 0.6  # least similarity of a misspelt name, as difflib counts it


class EditKind(StrEnum):
    """Kind of an edit; `put`, `rename`, `remove` and `insert` make one of each."""

    REPLACE = "replace"  # a value is put at a pointer: a key that may be there already, or an item that is
    RENAME = "rename"  # the last key of a pointer is called something else
    REMOVE = "remove"  # a key with its value, or an item, is taken out
    INSERT = "insert"  # an item is put into a list, before the one at a pointer


@dataclass(frozen=True)
class Edit:
    """One change of a file, at the pointer of what is changed or new; `value`: the new one, of RENAME the new key."""

    kind: EditKind
    pointer: KeyPath
    value: Any = None


put, rename, remove, insert = (partial(Edit, kind) for kind in EditKind)


@dataclass(frozen=True)
class Mend:
    """Correction of a fault: a sentence for people, in the imperative, and edits to apply in order."""

    sentence: str
    edits: tuple[Edit, ...] = ()

    @classmethod
    def write(cls, at: KeyPath, name: str = "", /, **values: Any) -> Mend:
        """Have keys written in the mapping at a pointer, which is that of something called `name`."""
        said = ", ".join(f"{key}: {flow_text(value)}" for key, value in values.items())
        edits = tuple(put((*at, key), value) for key, value in values.items())
        return cls(f"Write `{said}` for {name}." if name else f"Write `{said}`.", edits)

    @classmethod
    def take_out(cls, at: KeyPath, name: str) -> Mend:
        """Have what is at a pointer taken out."""
        return cls(f"Take out {name}.", (remove(at),))


@dataclass(frozen=True)
class Fault:
    """An error in a plan.

    Attributes:
        pointer: of the part that is wrong, as the file has it. expected, got: as in a RegistryError.
        mend: None if no sensible correction is near. old: the values that its edits replace.
        file, line: the location, counted from 1, in the file or that of the plan named by `like`; for a part that an
            earlier mend has added, where it was added. Before it is known: 0 if the pointer determines it.
    """

    pointer: KeyPath
    expected: str
    got: str
    mend: Mend | None = None
    line: int = 0
    file: str = ""
    old: tuple[Any, ...] = ()

    @property
    def facts(self) -> dict[str, Any]:
        """As JSON has it."""
        mend = None
        if self.mend is not None:
            pairs = zip(self.mend.edits, self.old, strict=True)
            edits = [{"op": e.kind, "pointer": [*e.pointer], "old": old, "new": e.value} for e, old in pairs]
            mend = {"sentence": self.mend.sentence, "edits": edits}
        said = {"pointer": [*self.pointer], "expected": self.expected, "got": self.got, "mend": mend}
        return {"file": self.file, "line": self.line, **said}


def value_at(value: Any, pointer: Sequence[str | int]) -> Any:
    """The value at a pointer; None if there is no value."""
    for step in pointer:
        if isinstance(value, dict):
            value = value.get(step)
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
        else:
            return None
    return value


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
            made = _edited(text, root, edit, wanted)
            if parse_document(made, "").value == wanted:
                return made
        except (RegistryError, KeyError, IndexError, TypeError):
            pass
    return block_text(wanted)


def _edited(text: str, root: yaml.Node, edit: Edit, wanted: Any) -> str:
    path, key = edit.pointer[:-1], edit.pointer[-1]
    parent = root
    for step in path:
        parent = _child(parent, step)[1]
    rows: list[Any] = parent.value if isinstance(parent, yaml.CollectionNode) else []
    is_new = edit.kind is EditKind.INSERT or not any(_is_at(row, n, key) for n, row in enumerate(rows))
    if is_new or edit.kind is EditKind.REMOVE:
        if _is_flow(parent) or len(rows) < 2:
            return _exchanged(text, parent, flow_text(value_at(wanted, path)))
        return _added(text, parent, key, edit) if is_new else _without(text, parent, key)
    at, node = _child(parent, key)
    if edit.kind is EditKind.RENAME:
        assert at is not None, "only a key is renamed"
        return text[: at.start_mark.index] + _key_text(str(edit.value)) + text[at.end_mark.index :]
    if at is None or _is_flow(parent) or not isinstance(edit.value, dict | list):
        is_item = at is None and not _is_flow(parent)
        return _exchanged(text, node, item_text(edit.value) if is_item else flow_text(edit.value))
    head = text.index(":", at.end_mark.index) + 1
    return text[:head] + _behind_key(edit.value, parent.start_mark.column) + text[max(_end(node), head) :]


def _is_at(row: Any, n: int, key: str | int) -> bool:
    """True if a row of a mapping or a list is that of a key or a number."""
    return str(row[0].value) == str(key) if isinstance(row, tuple) else n == key


def _child(parent: yaml.Node, step: str | int) -> tuple[yaml.Node | None, yaml.Node]:
    row = next((row for n, row in enumerate(parent.value) if _is_at(row, n, step)), None)
    if row is None or isinstance(row, str):
        raise KeyError(step)
    return row if isinstance(row, tuple) else (None, row)


def _end(node: yaml.Node) -> int:
    """Where what is written of a node ends; YAML lets collections in block form end where the next thing begins."""
    if isinstance(node, yaml.ScalarNode) or _is_flow(node) or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    return _end(last[1] if isinstance(node, yaml.MappingNode) else last)


def _is_flow(node: yaml.Node) -> bool:
    return isinstance(node, yaml.CollectionNode) and bool(node.flow_style)


def _line_start(text: str, index: int) -> int:
    return text.rfind("\n", 0, index) + 1


def _line_end(text: str, index: int) -> int:
    end = text.find("\n", index)
    return len(text) if end < 0 else end + 1


def _exchanged(text: str, node: yaml.Node, new: str) -> str:
    start = int(node.start_mark.index)
    gap = " " if start and text[start - 1] in ":-" else ""
    return text[:start] + gap + new + text[max(_end(node), start) :]


def _added(text: str, parent: yaml.Node, key: str | int, edit: Edit) -> str:
    column, rows, is_item = parent.start_mark.column, parent.value, edit.kind is EditKind.INSERT
    at = _line_end(text, _end(parent))
    if is_item and int(key) < len(rows):
        at = _line_start(text, rows[int(key)].start_mark.index)
    line = f"- {item_text(edit.value)}" if is_item else f"{_key_text(str(key))}:{_behind_key(edit.value, column)}"
    head = text[:at] if not at or text[:at].endswith("\n") else text[:at] + "\n"
    return f"{head}{' ' * column}{line}\n{text[at:]}"


def _without(text: str, parent: yaml.Node, key: str | int) -> str:
    is_map = isinstance(parent, yaml.MappingNode)
    rows = [(k, v) for k, v in parent.value] if is_map else [(v, v) for v in parent.value]
    n = next(n for n, row in enumerate(parent.value) if _is_at(row, n, key))
    start, end = rows[n][0].start_mark.index, _end(rows[n][1])
    if is_map and text[_line_start(text, start) : start].strip() and n + 1 < len(rows):  # the first of a list's item
        return text[:start] + text[rows[n + 1][0].start_mark.index :]
    return text[: _line_start(text, start)] + text[_line_end(text, end) :]


def _behind_key(value: Any, column: int) -> str:
    """A value as it is written behind a key and its colon: in the line where that is short, else in lines below."""
    line, items = flow_text(value), list(value.values()) if isinstance(value, dict) else value
    if not isinstance(value, dict | list) or not value:
        return f" {line}"
    is_deep = any(isinstance(item, dict | list) for item in items)
    return "\n" + block_text(value, column + 2).rstrip("\n") if is_deep or len(line) + column >= WIDE else f" {line}"


def flow_text(value: Any) -> str:
    """A value in one line of YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key_text(str(k))}: {flow_text(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow_text(v) for v in value) + "]"
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    if isinstance(value, float):
        return f"{value:.10g}" if math.isfinite(value) else f"{value}".replace("i", ".i").replace("nan", ".nan")
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
    except (OSError, ValueError) as error:
        raise RegistryError(path.name, 1, "", "a readable file of YAML in UTF-8", str(error)) from None


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet. Raises OutputError where it is."""
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise OutputError(str(path), "is there already; name another file") from None
