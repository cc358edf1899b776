"""Plans and styles of registry/, each a file of its own, named after its id."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import Style
from casa_assets.model.record import Record
from casa_assets.model.registry.document import Document
from casa_assets.registry import data_root, read_document, read_record

R = TypeVar("R", bound=Record)
PLANS, STYLES = "plans", "styles"


def plan_names() -> tuple[str, ...]:
    """Ids of all plans, sorted."""
    return _names(PLANS)


def style_names() -> tuple[str, ...]:
    """Ids of all styles, sorted."""
    return _names(STYLES)


def load_plan(name: str) -> tuple[Plan, Document]:
    """A plan and the document that it was read from, which tells the lines of its parts.

    Raises:
        UnknownId: there is none of that name. RegistryError: its file is no plan.
    """
    return _load(Plan, PLANS, "plan", name)


def load_style(name: str) -> tuple[Style, Document]:
    """A style and its document. Raises UnknownId, RegistryError."""
    return _load(Style, STYLES, "style", name)


def read_plan(path: Path) -> tuple[Plan, Document]:
    """A plan from any file; its id is the stem of the name. Raises RegistryError."""
    document = read_document(path)
    return read_record(Plan, document.value, document, (), id=path.stem), document


def _load(kind: type[R], folder: str, noun: str, name: str) -> tuple[R, Document]:
    path = data_root() / folder / f"{name}.yaml"
    if name not in _names(folder):
        raise UnknownId(noun, name, _names(folder))
    document = read_document(path)
    if not isinstance(document.value, dict):
        raise RegistryError(path.name, 1, "", f"a {noun}", type(document.value).__name__)
    return read_record(kind, document.value, document, (), id=name), document


def _names(folder: str) -> tuple[str, ...]:
    return tuple(sorted(p.stem for p in (data_root() / folder).glob("*.yaml")))
