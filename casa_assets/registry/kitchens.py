"""Plans and styles of registry/ and of the project in use, each in a file named after its id."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import Mixing, Style
from casa_assets.model.record import Record
from casa_assets.model.registry.document import Document, expected_one_of
from casa_assets.projects import project_folder, read_once
from casa_assets.registry.read import names_in, read_document, read_record, read_table_file, read_topmost, stated_in

R = TypeVar("R", bound=Record)
PLANS, STYLES = "plans", "styles"
MODELS, PRESET = "models", "preset"  # keys of a style, and of a model in it
MIXING_FILE = "mixing.yaml"
LIKE = "like"  # key of a plan or a style: the name of one from which it differs by what else it states


def plan_names() -> tuple[str, ...]:
    """Ids of all plans, sorted."""
    return names_in(PLANS)


def style_names() -> tuple[str, ...]:
    """Ids of all styles, sorted."""
    return names_in(STYLES)


def load_plan(name: str) -> tuple[Plan, Document]:
    """A plan and the document that it was read from, which has the line numbers of its parts.

    Raises UnknownId: no plan has that name. RegistryError: its file is not a valid plan.
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
    if name not in names_in(folder):
        raise UnknownId(noun, name, names_in(folder))
    document = _document(folder, noun, name)
    return read_record(kind, document.value, document, (), id=name), document


def _document(
    folder: str, noun: str, name: str, below: Path | None = None, seen: tuple[Document, ...] = ()
) -> Document:
    """A plan or a style as its file states it, laid over the one that it is `like`.

    One that is `like` its own name is laid over that of the package. `below`: a layer; the file is looked for in the
    layers below it. `seen`: documents that are laid over it.
    """
    document = read_topmost(f"{folder}/{name}.yaml", below)
    if not isinstance(document.value, dict):
        raise RegistryError(document.file, 1, "", f"a {noun}", type(document.value).__name__)
    if document.file in {one.file for one in seen}:
        raise seen[-1].fault((LIKE,), f"a {noun} that is not like this one", repr(name))
    return document if LIKE not in document.value else laid_over_like(document, name, folder, noun, seen)


def laid_over_like(
    document: Document, name: str, folder: str = PLANS, noun: str = "plan", seen: tuple[Document, ...] = ()
) -> Document:
    """The document of a plan or a style that is `like` another, laid over that one. Raises RegistryError."""
    base, known = str(document.value[LIKE]), names_in(folder)
    if base not in known:
        raise document.fault((LIKE,), expected_one_of(known, base), repr(base))
    if base == name and len(stated_in(f"{folder}/{base}.yaml")) == 1:
        raise document.fault((LIKE,), f"a {noun} that is not like this one", repr(base))
    lower = _document(folder, noun, base, project_folder() if base == name else None, (*seen, document))
    value = {key: value for key, value in document.value.items() if key != LIKE}
    own = replace(document, value=value, lines={path: at for path, at in document.lines.items() if path[:1] != (LIKE,)})
    joined = _without_replaced(lower, own).overlaid(own)
    files = {path: joined.files.get(path, lower.file) for path in joined.lines}
    return replace(joined, file=document.file, files=MappingProxyType(files))


def _without_replaced(lower: Document, upper: Document) -> Document:
    """The lower style without the models for which the upper one names a preset: its parameters fit its preset only."""
    models, chosen = lower.value.get(MODELS), upper.value.get(MODELS)
    if not isinstance(models, dict) or not isinstance(chosen, dict):
        return lower
    replaced = {(MODELS, role) for role, choice in chosen.items() if isinstance(choice, dict) and PRESET in choice}
    kept = {role: choice for role, choice in models.items() if (MODELS, role) not in replaced}
    lines = {path: line for path, line in lower.lines.items() if path[:2] not in replaced}
    files = {path: file for path, file in lower.files.items() if path[:2] not in replaced}
    value = {**lower.value, MODELS: kept}
    return replace(lower, value=value, lines=MappingProxyType(lines), files=MappingProxyType(files))


@read_once
def load_mixing() -> Mixing:
    """The rules. Raises RegistryError where the file is wrong, or names a role that no style has."""
    document = read_table_file(MIXING_FILE)
    mixing = read_record(Mixing, document.value, document, ())
    known = {role for name in style_names() for role in load_style(name)[0].models}
    for suite, roles in mixing.suites.items():
        for i, role in enumerate(roles):
            if role not in known:
                raise document.fault(("suites", suite, i), "a role of the styles", repr(role))
    return mixing
