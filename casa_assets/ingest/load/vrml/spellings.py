"""Text of VRML 2.0, or XML of X3D, -> nodes; nothing is run, and no file or address that they name is opened."""

from __future__ import annotations

import re
from collections.abc import Iterator

from lxml import etree

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.collada.guarded_xml import check_xml, local_name
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.load.text import decode
from casa_assets.ingest.load.vrml.node import DEEPEST, Node

_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|[\[\]{}]|[^\s,"\[\]{}#]+|#[^\n]*')
_NUMBER = re.compile(r"[-+]?(\d|\.\d|inf|nan)", re.IGNORECASE)
# The document type of X3D names a file of rules and holds none itself; with one of its own it is refused.
_PLAIN_DOCTYPE = re.compile(rb"<!DOCTYPE\s+X3D\s+(PUBLIC\s+(\"[^\"<>&\[\]]*\"\s*){2}|SYSTEM\s+\"[^\"<>&\[\]]*\"\s*)>")


def nodes_of_xml(data: bytes, name: str) -> list[Node]:
    """Nodes of an X3D scene, and `unit` nodes of its head.

    Raises:
        Rejected: XML_ENTITY, XML_DEPTH, TRUNCATED, BAD_XML, SCENE_UNREADABLE.
    """
    plain = _PLAIN_DOCTYPE.sub(b"", data[:4096], count=1) + data[4096:]
    check_xml(plain, name)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True, remove_comments=True, remove_pis=True
    )
    try:
        root = etree.fromstring(plain, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        message = f"{name}: the XML is broken ({printable(str(error), 80)}); export it again"
        raise Rejected(codes.BAD_XML, message) from error
    scene = next((child for child in root if local_name(child) == "Scene"), None)
    if scene is None:
        raise Rejected(codes.SCENE_UNREADABLE, f"{name}: X3D without a Scene; export it again")
    known: dict[str, Node] = {}
    top = Node("Scene")
    stack: list[tuple[Iterator[etree._Element], Node]] = [(iter(scene), top)]
    while stack:
        element = next(stack[-1][0], None)
        if element is None:
            stack.pop()
            continue
        siblings = stack[-1][1].nodes.setdefault("children", [])
        used = element.get("USE")
        if used is not None:
            siblings += [known[used]] if used in known else []
            continue
        node = Node(local_name(element), element.get("DEF", ""), {str(k): str(v) for k, v in element.attrib.items()})
        siblings.append(node)
        if node.name:
            known[node.name] = node
        if len(stack) > DEEPEST:
            raise _too_deep(name)
        stack.append((iter(element), node))
    units = [Node("unit", "", {str(k): str(v) for k, v in e.attrib.items()}) for e in root.iter() if _is_unit(e)]
    return [*top.nodes.get("children", []), *units]


def _is_unit(element: etree._Element) -> bool:
    return local_name(element) == "unit" and element.get("category") == "length"


def nodes_of_text(data: bytes, name: str) -> list[Node]:
    """Nodes of a VRML 2.0 scene. Raises Rejected UNSUPPORTED_VERSION, TRUNCATED, SCENE_UNREADABLE."""
    text = decode(data)
    if not re.match(r"#VRML V2\.0", text):
        message = f"{name}: VRML {printable(text[6:12], 10)!r}; only 2.0 (VRML97) can be read; convert it to GLB"
        raise Rejected(codes.UNSUPPORTED_VERSION, message)
    return _Words(text, name).nodes()


class _Words:
    """Reads nodes word by word."""

    def __init__(self, text: str, name: str) -> None:
        self._words = (w.group() for w in _WORD.finditer(text))
        self._next = ""
        self._name = name
        self._known: dict[str, Node] = {}
        self._protos: set[str] = set()
        self._take()

    def nodes(self) -> list[Node]:
        found: list[Node] = []
        while self._next:
            if self._next in ("]", "}"):
                self._take()  # one too many; programs read on, too
                continue
            node = self._statement(0)
            if node is not None:
                found.append(node)
        return found

    def _take(self) -> str:
        taken = self._next
        self._next = next((word for word in self._words if not word.startswith("#")), "")
        return taken

    def _statement(self, depth: int) -> Node | None:
        """A node, or a name for one; routes and prototypes are read over."""
        word = self._take()
        if word == "DEF":
            name = self._take()
            return self._node(self._take(), depth, name)
        if word == "USE":
            return self._known.get(self._take())
        if word == "ROUTE":
            for _ in range(3):
                self._take()
            return None
        if word in ("PROTO", "EXTERNPROTO"):
            self._protos.add(self._take())
            self._skip_brackets()
            if self._next in ("{", "[") or self._next.startswith('"'):
                self._skip_brackets()
            return None
        return self._node(word, depth, "")

    def _node(self, kind: str, depth: int, name: str) -> Node | None:
        if depth > DEEPEST:
            raise _too_deep(self._name)
        if self._next != "{":
            if not self._next:
                raise _cut(self._name)
            return None  # not a node; what stands there is read over
        self._take()
        node = Node(kind, name)
        if name:
            self._known[name] = node
        if kind == "Script" or kind in self._protos:
            self._skip_inside()
            return node
        while self._next != "}":
            if not self._next:
                raise _cut(self._name)
            self._field(node, self._take(), depth)
        self._take()
        return node

    def _field(self, node: Node, field: str, depth: int) -> None:
        """One field: words, or nodes."""
        if self._next == "[":
            self._take()
            words: list[str] = []
            while self._next != "]":
                if not self._next:
                    raise _cut(self._name)
                if self._is_value(self._next):
                    words.append(self._take())
                else:
                    self._add(node, field, self._statement(depth + 1))
            self._take()
            node.fields[field] = " ".join(words)
            return
        words = []
        while self._next and self._is_value(self._next):
            words.append(self._take())
        if words:
            node.fields[field] = " ".join(words)
        elif self._next in ("{", "["):
            self._skip_brackets()
        elif field in ("ROUTE", "IS"):
            self._take()
        elif self._next and self._next != "}":
            self._add(node, field, self._value_node(depth))

    def _value_node(self, depth: int) -> Node | None:
        """The node of a field with one; NULL is none. Another field's name is left where it is."""
        if self._next == "NULL":
            self._take()
            return None
        return self._statement(depth + 1) if self._next[:1].isupper() else None

    def _add(self, node: Node, field: str, child: Node | None) -> None:
        if child is not None:
            node.nodes.setdefault(field, []).append(child)

    def _is_value(self, word: str) -> bool:
        return word.startswith('"') or word in ("TRUE", "FALSE") or _NUMBER.match(word) is not None

    def _skip_brackets(self) -> None:
        """Read over what stands in one pair of brackets, or over words up to them."""
        while self._next and self._next not in ("{", "["):
            if not self._next.startswith('"'):
                return
            self._take()
        if self._next:
            self._take()
            self._skip_inside()

    def _skip_inside(self) -> None:
        open_ = 1
        while open_:
            if not self._next:
                raise _cut(self._name)
            word = self._take()
            open_ += (word in ("{", "[")) - (word in ("}", "]"))


def _cut(name: str) -> Rejected:
    return Rejected(codes.TRUNCATED, f"{name}: the VRML ends within a node; fetch it again")


def _too_deep(name: str) -> Rejected:
    return Rejected(codes.SCENE_UNREADABLE, f"{name}: nodes nested deeper than {DEEPEST}; export it again")
