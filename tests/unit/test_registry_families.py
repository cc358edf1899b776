"""Presets, looks and densities in registry/: joined to the code of families, with file and line of faults."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from casa_assets import kitchenware
from casa_assets.asset.assemble import Family
from casa_assets.asset.family import Params
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.kitchenware.catalog import MODELS
from casa_assets.registry import data_root, read_document
from casa_assets.registry.families import (
    Parameter,
    families,
    family,
    family_groups,
    family_names,
    look_samplers,
    looks,
    parameters_of,
    read_family,
)
from casa_assets.registry.load import read_densities
from tests.support.asset.family_members import WOODS, available, known
from tests.support.program.projects import Project

GOOD = """\
title: Vase
category: vase
description: Vases.
presets:
  plain: {}
  tall: {height: 0.28, shape: bottle}
sample:
  shape: any
"""
ISLAND = GOOD.replace("vase", "island_base").split("  plain")[0]


def read(tmp_path: Path, text: str, name: str = "vase") -> Family[Params]:
    path = tmp_path / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    return read_family(MODELS[name], read_document(path))


def test_every_family_has_a_file_and_every_file_a_family() -> None:
    files = {p.stem for p in (data_root() / "families").glob("*.yaml")}
    assert files == set(MODELS) == set(families()) == set(family_names())
    assert {f.name for group in family_groups().values() for f in group} == files


def test_every_parameter_is_described() -> None:
    rows = {name: parameters_of(found.params) for name, found in families().items()}
    assert not [(name, row.name) for name, found in rows.items() for row in found if not row.description]
    assert Parameter("width", "number", "0.75", "0.56 to 0.92", "of the plate, m") in rows["hob"]
    assert Parameter("row", "front | right", "front", "", "place of the knobs") in rows["hob"]
    narrowed, look = rows["fridge_side_by_side"][0], rows["wall_cabinet"][-1]
    assert (narrowed.bounds, narrowed.description) == ("0.83 to 0.92", "outside, m")
    assert (look.name, look.kind) == ("look.metal", "finish")
    schema = families()["hob"].params.model_json_schema()
    assert schema["properties"]["width"]["description"] == "of the plate, m"


def test_presets_differ_and_state_nothing_that_is_the_default_already() -> None:
    for name, found in families().items():
        assert len({p.digest for p in found.presets.values()}) == len(found.presets) > 0, name
        rows = read_document(data_root() / "families" / f"{name}.yaml").value["presets"]
        plain = {key for key, field in found.params.model_fields.items() if not field.is_required()}
        default = {key: found.params.model_fields[key].get_default() for key in plain}
        for preset, row in rows.items():
            made = found.presets[preset]
            same = [key for key in row if key in plain and getattr(made, key) == default[key]]
            assert not same, (name, preset, same)


def test_a_preset_is_the_defaults_and_what_its_row_states_and_a_look_is_named_or_written_out(tmp_path: Path) -> None:
    found = read(tmp_path, GOOD)
    assert (found.title, found.category, found.description) == ("Vase", "vase", "Vases.")
    assert found.presets["plain"] == found.params()
    assert found.presets["tall"] == found.params.model_validate({"height": 0.28, "shape": "bottle"})
    written = "{handle: cup, face: paint_navy, metal: brass_brushed}"
    found = read(tmp_path, ISLAND + f"  named: {{look: navy_cups}}\n  written: {{look: {written}}}\n", "island_base")
    assert found.presets["named"] == found.presets["written"]
    assert found.presets["named"].model_dump()["look"] == looks()["navy_cups"].model_dump()
    with pytest.raises(RegistryError, match="'navy_cups', or another one of") as caught:
        read(tmp_path, ISLAND + "  blue: {look: navy_cup}\n", "island_base")
    assert (caught.value.line, caught.value.pointer) == (5, "presets.blue.look")


def test_a_fault_names_file_line_pointer_and_what_was_expected(tmp_path: Path) -> None:
    for change, line, pointer, expected in [
        (("height: 0.28", "hight: 0.28"), 6, "presets.tall.hight", "'height', or another one of"),
        (("height: 0.28", "height: 28"), 6, "presets.tall.height", "less than or equal to 0.3"),
        (("shape: bottle", "shape: botle"), 6, "presets.tall.shape", "'bottle'"),
        (("plain: {}", "plain: 3"), 5, "presets.plain", "a mapping"),
        (("category: vase", "category: vace"), 2, "category", "'vase', or another one of"),
        (("title: Vase\n", ""), 1, "title", "Field required"),
        (("presets:", "preset:"), 4, "preset", "'presets', or another one of"),
        (("  tall:", "  plain:"), 6, "presets.plain", "each key once"),
        (("sample:\n  shape: any\n", ""), 1, "sample", "rules"),
        (("shape: any", "shap: any"), 8, "sample.shap", "'shape', or another one of"),
        (("shape: any", "shape: botle"), 8, "sample.shape", "'bottle'"),
        (("shape: any", "radius: any"), 8, "sample.radius", "neither an enumeration nor a look"),
        (("shape: any", "radius: {range: [0.05, 0.8], step: 0.01}"), 8, "sample.radius", "less than or equal to 0.09"),
        (("shape: any", "radius: {range: [0.05, 0.08]}"), 8, "sample.radius", "a rule of a random member"),
        (("shape: any", "shape: any\n  stems: {by: shap, else: 3}"), 9, "sample.stems", "'shape', or another one of"),
        (("shape: any", "shape: any\n  stems: {by: shape, bottle: 3}"), 9, "sample.stems", "also a rule for "),
        (("shape: any", "shape: any\n  stems: {by: shape, botle: 3, else: 4}"), 9, "sample.stems.botle", "'bottle'"),
    ]:
        with pytest.raises(RegistryError) as caught:
            read(tmp_path, GOOD.replace(*change))
        assert (caught.value.file, caught.value.line, caught.value.pointer) == ("vase.yaml", line, pointer)
        assert expected in caught.value.expected


RULES = """\
sample:
  _short: {chance: 0.5}
  shape: [bottle, bottle]
  radius: {range: [0.05, 0.06], step: 0.01}
  height: {by: _short, true: 0.2, else: {sum: [{same_as: radius}, {product: [2, 0.1]}]}}
  stems: {by: shape, bottle or urn: {integers: [4, 5]}, else: 3}
  clay: {surface: cabinet}
"""


def test_a_random_member_is_drawn_by_the_rules_from_top_to_bottom(tmp_path: Path) -> None:
    found = read(tmp_path, GOOD.split("sample:", maxsplit=1)[0] + RULES)
    drawn = [found.draw(np.random.default_rng(seed), available()).model_dump() for seed in range(40)]
    assert {(row["radius"], row["height"]) for row in drawn} == {(0.05, 0.2), (0.06, 0.2), (0.05, 0.25), (0.06, 0.26)}
    assert {(row["shape"], row["stems"]) for row in drawn} == {("bottle", 4), ("bottle", 5)}
    assert {row["clay"] for row in drawn} == set(WOODS)
    rng = np.random.default_rng(0)
    short = rng.random() < 0.5
    rng.integers(2)
    radius = 0.05 + 0.01 * int(rng.integers(2))
    assert (drawn[0]["radius"], drawn[0]["height"]) == (radius, 0.2 if short else round(radius + 0.2, 3))


def test_rules_beside_a_function_unknown_families_and_faults_in_rules_of_looks_are_errors(
    project: Project, tmp_path: Path
) -> None:
    with pytest.raises(RegistryError, match="no rules, since its code has `sample`"):
        read(tmp_path, ISLAND + "  plain: {}\nsample: {look: any}\n", "island_base")
    with pytest.raises(UnknownId, match="microwave"):
        family("micro_wave")
    folder = project({"families/vasse.yaml": GOOD})
    with pytest.raises(RegistryError, match="'vase', or another one of") as caught:
        families()
    assert caught.value.file == f"{folder}/families/vasse.yaml"
    folder = project({"look_rules.yaml": "cabinet: {}\nappliance:\n  form: [flat, flatt]\n"})
    with pytest.raises(RegistryError, match="'flat'") as caught:
        look_samplers()
    assert caught.value.file == f"{folder}/look_rules.yaml"
    assert (caught.value.line, caught.value.pointer) == (3, "appliance.form.1")


# Densities: no family states one --------------------------------------------------------------------------------------

SOURCES = sorted(Path(kitchenware.__path__[0]).rglob("*.py"))
DENSITIES = read_document(data_root() / "densities.yaml").value


def stated(tree: ast.AST) -> Iterator[ast.Constant]:
    """Constants that are given as densities: arguments, and defaults of parameters, called `density`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "density":
            yield from (n for n in ast.walk(node.value) if isinstance(n, ast.Constant))
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "density" for t in node.targets):
            yield from (n for n in ast.walk(node.value) if isinstance(n, ast.Constant) and isinstance(n.value, float))


def test_no_family_states_a_density_in_numbers_and_every_row_is_used() -> None:
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES}
    found = [(path, c) for path, tree in trees.items() for c in stated(tree)]
    assert [(n, c.lineno) for n, c in found if c.value not in (None, 0.0) and not isinstance(c.value, str)] == []
    assert set(DENSITIES) <= {n.value for tree in trees.values() for n in ast.walk(tree) if isinstance(n, ast.Constant)}


def test_a_row_is_a_number_or_a_share_of_a_substance() -> None:
    densities, substances = known().densities, known().substances
    assert densities["hood_body"] == DENSITIES["hood_body"]["kg_m3"]
    assert densities["tap_body"] == substances["brass"].density * DENSITIES["tap_body"]["fill"]
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
