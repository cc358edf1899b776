"""Decisions of a person on articulated meshes: decisions.yaml of one, review.json of a library.

The page of review makes review.json, and `casa-assets articulate --decisions review.json` takes it into the library.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pydantic import Field

from casa_assets import registry
from casa_assets.articulate.decisions import Decisions
from casa_assets.library.library import Library
from casa_assets.model.record import Record, Sha256

NAME = "review.json"


class ReviewFile(Record):
    """The decisions on many meshes, by the sha256 of each with all its files."""

    meshes: dict[Sha256, Decisions] = Field(default_factory=dict)


def read_decisions(path: Path) -> Decisions:
    """Read a decisions.yaml. Raises RegistryError with file and line where it is invalid."""
    document = registry.read_document(path)
    return registry.read_record(Decisions, document.value, document, ())


def read_review(path: Path) -> dict[str, Decisions]:
    """Read a review.json. Raises RegistryError with file and line where it is invalid, UnknownId for a category."""
    document = registry.read_document(path)
    found = registry.read_record(ReviewFile, document.value, document, ()).meshes
    for decisions in found.values():
        check_category(decisions)
    return found


def check_category(decisions: Decisions) -> None:
    """Raise UnknownId where decisions name a category that the registry does not know."""
    known = registry.load()
    if decisions.category is not None and decisions.category not in known.fixtures:
        known.category(decisions.category)


def mesh_decisions(library: Library) -> dict[str, Decisions]:
    """Return the decisions made in a library so far; empty if it has no file of decisions."""
    path = library.root / NAME
    return read_review(path) if path.exists() else {}


def keep_mesh_decisions(library: Library, changes: Mapping[str, Decisions]) -> dict[str, Decisions]:
    """Put decisions into the review.json of a library, in place of older ones on the same meshes; return all of them.

    Decisions that say nothing take those of the mesh away.
    """
    before = mesh_decisions(library)
    after = {sha256: one for sha256, one in {**before, **changes}.items() if one != Decisions()}
    if after != before:
        rows = {sha256: one.model_dump(mode="json", exclude_defaults=True) for sha256, one in sorted(after.items())}
        library.write(NAME, json.dumps({"meshes": rows}, indent=1) + "\n")
    return after
