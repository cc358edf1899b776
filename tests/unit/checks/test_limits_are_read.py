"""Every number in registry/limits.yaml decides something: a check or a stage reads it, and uses what it read.

Numbers of checks: the table hands them over, shown with a mapping that notes what it is asked for, and each function
uses every parameter that it is given. Numbers of stages: the sources are parsed, and a number counts as read where it
is taken out of a mapping of limits by its key.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from casa_assets import registry
from casa_assets.checks.check import Check, Measurement, run
from casa_assets.checks.table import TABLE
from casa_assets.textures.check import SET_CHECKS
from casa_assets.textures.check import TABLE as TEXTURES

ROOT = Path(__file__).parents[3] / "casa_assets"
LIMITS = registry.load().limits


class Noted(Mapping[str, float]):
    def __init__(self) -> None:
        self.read: set[str] = set()

    def __getitem__(self, key: str) -> float:
        self.read.add(key)
        return LIMITS[key]

    def __iter__(self) -> Iterator[str]:
        return iter(LIMITS)

    def __len__(self) -> int:
        return len(LIMITS)


def handed_over() -> set[str]:
    """Keys that the table hands to its functions, seen while it runs with functions that note what they get."""
    noted = Noted()
    for row in TABLE:

        def got(_: object, *limits: float, row: Check = row) -> Measurement:
            assert limits == tuple(LIMITS[key] for key in (row.limit, *row.others) if key)
            return Measurement(0.0)

        assert len(run(object(), "any", noted, table=[replace(row, subject=object, function=got)]).results) == 1
    return noted.read


def taken_by_key() -> set[str]:
    """Keys that the sources take out of a mapping of limits: `limits["key"]`, `brief.limits["key"]`."""
    found = set()
    for path in sorted(ROOT.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
                name = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
                if name.endswith("limits"):
                    found.add(str(node.slice.value))
    return found


def test_every_limit_is_read() -> None:
    textures = {row.limit for row in TEXTURES} | {key for _, key, _ in SET_CHECKS.values()}
    assert LIMITS.keys() - handed_over() - textures - taken_by_key() == set()


def test_no_limit_is_asked_for_that_is_not_there() -> None:
    assert handed_over() <= LIMITS.keys()


def uses_all(check: Check) -> bool:
    """Whether the function of a check takes as many numbers as its row hands it, and reads each of them."""
    parameters = list(inspect.signature(check.function).parameters.values())[1:]
    spread = any(p.kind is p.VAR_POSITIONAL for p in parameters)
    tree = ast.parse(textwrap.dedent(inspect.getsource(check.function)))
    asserted = {id(node) for a in ast.walk(tree) if isinstance(a, ast.Assert) for node in ast.walk(a)}
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and id(node) not in asserted}
    right = spread or len(parameters) == (check.limit is not None) + len(check.others)
    return right and {p.name for p in parameters} <= used


def test_a_check_uses_every_number_that_it_is_given() -> None:
    assert [check.code for check in TABLE if not uses_all(check)] == []
