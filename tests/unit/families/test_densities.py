"""Densities of parts are named rows of registry/densities.yaml; no family states one."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from casa_assets import kitchenware
from casa_assets.errors import RegistryError
from casa_assets.registry import data_root, read_document
from casa_assets.registry.load import read_densities
from tests.support.asset.family_members import known

SOURCES = sorted(Path(kitchenware.__path__[0]).rglob("*.py"))
ROWS = read_document(data_root() / "densities.yaml").value


def stated(tree: ast.AST) -> Iterator[ast.Constant]:
    """Constants that are given as densities: arguments, and defaults of parameters, called `density`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "density":
            yield from (n for n in ast.walk(node.value) if isinstance(n, ast.Constant))
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "density" for t in node.targets):
            yield from (n for n in ast.walk(node.value) if isinstance(n, ast.Constant) and isinstance(n.value, float))


def test_no_family_states_a_density_in_numbers() -> None:
    found = [(path.name, c) for path in SOURCES for c in stated(ast.parse(path.read_text(encoding="utf-8")))]
    assert [(n, c.lineno) for n, c in found if c.value not in (None, 0.0) and not isinstance(c.value, str)] == []


def test_every_row_is_used_by_a_family() -> None:
    words = {n.value for p in SOURCES for n in ast.walk(ast.parse(p.read_text())) if isinstance(n, ast.Constant)}
    assert set(ROWS) <= words


def test_a_row_is_a_number_or_a_share_of_a_substance() -> None:
    densities, substances = known().densities, known().substances
    assert densities["hood_body"] == ROWS["hood_body"]["kg_m3"]
    assert densities["tap_body"] == substances["brass"].density * ROWS["tap_body"]["fill"]
    assert densities["glass"] == substances["glass"].density


def test_a_faulty_row_is_told_with_line_and_pointer(tmp_path_factory: pytest.TempPathFactory) -> None:
    for row, pointer, expected in [
        ("a: {kg_m3: 0, why: x}", "a.kg_m3", "greater than 0"),
        ("a: {why: x}", "a", "either kg_m3 or a substance"),
        ("a: {kg_m3: 5, fill: 0.5, why: x}", "a", "fill is the share of a substance"),
        ("a: {substance: stel, why: x}", "a.substance", "'steel', or another one of"),
        ("steel: {kg_m3: 5, why: x}", "steel", "a name that no substance has"),
    ]:
        path = tmp_path_factory.mktemp("case") / "densities.yaml"
        path.write_text(f"# one row\n{row}\n", encoding="utf-8")
        with pytest.raises(RegistryError) as caught:
            read_densities(read_document(path), known().substances)
        assert (caught.value.file, caught.value.line, caught.value.pointer) == ("densities.yaml", 2, pointer)
        assert expected in caught.value.expected
