"""COLLADA bytes -> a guarded element tree: no entities, no network, no depth, and look-ups that cannot recurse."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.parsers import expat

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.core.numeric import Floats
from casa_assets.errors import Rejected
from casa_assets.formats.read.text import parsed_numbers, printable
from casa_assets.model import rejection_codes as codes

Element = etree._Element

# COLLADA files are about a dozen deep, plus their node hierarchy.
MAX_DEPTH = 500
_CUT = tuple(
    expat.errors.codes[words] for words in (expat.errors.XML_ERROR_NO_ELEMENTS, expat.errors.XML_ERROR_UNCLOSED_TOKEN)
)


def check_xml(data: bytes, name: str) -> None:
    """Scan before parsing. Raises Rejected."""
    depth = 0

    def start(tag: str, attributes: object) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            raise Rejected(codes.XML_DEPTH, f"{name}: XML nested deeper than {MAX_DEPTH}; export it again")

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1

    def doctype(*parts: object) -> None:
        raise Rejected(codes.XML_ENTITY, f"{name}: carries a document type or entities; remove them")

    scanner = expat.ParserCreate()
    scanner.StartElementHandler, scanner.EndElementHandler = start, end
    scanner.StartDoctypeDeclHandler = doctype
    try:
        scanner.Parse(data, True)
    except expat.ExpatError as error:
        code = codes.TRUNCATED if error.code in _CUT else codes.BAD_XML
        message = f"{name}: the XML is broken at line {error.lineno} ({expat.ErrorString(error.code)}); fetch it again"
        raise Rejected(code, message) from error
    except (ValueError, LookupError) as error:
        message = f"{name}: the XML cannot be read ({printable(str(error), 60)}); export it again"
        raise Rejected(codes.BAD_XML, message) from error


def parse_xml(data: bytes, name: str) -> Element:
    """Root of a tree without comments. Raises Rejected as `check_xml`."""
    check_xml(data, name)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True, remove_comments=True, remove_pis=True
    )
    try:
        return etree.fromstring(data, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise broken_xml(error, name) from error


def broken_xml(error: Exception, name: str) -> Rejected:
    """The refusal of XML that lxml cannot read, such as a prefix that is not declared, which `check_xml` lets pass."""
    return Rejected(codes.BAD_XML, f"{name}: the XML is broken ({printable(str(error), 80)}); export it again")


def local_name(element: Element) -> str:
    """Name without namespace."""
    name = element.tag
    return name.rpartition("}")[2] if isinstance(name, str) else ""


def children(element: Element | None, *names: str) -> Iterator[Element]:
    """Children with one of these names, in order; all children if no names are given."""
    for child in element if element is not None else ():
        if not names or local_name(child) in names:
            yield child


def find_path(element: Element | None, *path: str) -> Element | None:
    """First descendant along a path of names, or None."""
    for name in path:
        element = next(children(element, name), None)
    return element


def text_of(element: Element | None) -> str:
    """Text, stripped; empty if there is no element or no text."""
    return (element.text or "").strip() if element is not None else ""


def floats_of(element: Element | None) -> Floats:
    """(N,) numbers of an element's text; what is not a number becomes NaN."""
    text = text_of(element).encode("ascii", "replace")
    flat = parsed_numbers(text.replace(b"\n", b" ").replace(b"\t", b" ").replace(b"\r", b" "))
    return flat if flat is not None else np.array([number_of(word) for word in text.split()])


def integers_of(element: Element | None) -> npt.NDArray[np.int64]:
    """(N,) whole numbers of an element's text; other words, and numbers of 2**53 or more, become -1."""
    flat = floats_of(element)
    good = np.isfinite(flat) & (np.abs(flat) < 2**53)
    return np.where(good, np.where(good, flat, 0.0), -1.0).astype(np.int64)


def number_of(word: bytes | str) -> float:
    """The number that a word is; NaN if it is none."""
    try:
        return float(word)
    except ValueError:
        return math.nan


def count_of(element: Element, attribute: str, default: int) -> int:
    """Whole number >= 0 in an attribute; the default where it is missing or wrong."""
    value = element.get(attribute, "").strip()
    return int(value) if value.isdigit() and len(value) < 10 else default
