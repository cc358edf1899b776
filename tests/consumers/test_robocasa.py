"""Objects of an export in robosuite, read and placed as RoboCasa's object class does (see robosuite_objects.py)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from casa_assets.addons.robocasa.run import export
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import BOXES, box_obj, casa
from tests.support.program.environments import found_by

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Objects built in code and three that ingest made."""
    root = tmp_path_factory.mktemp("robocasa")
    (root / "in").mkdir()
    for name, size in BOXES.items():
        (root / "in" / f"{name}.obj").write_text(box_obj(size), encoding="ascii")
    assert casa("ingest", root / "in", "--library", root / "library").returncode == 0
    keep(root / "library", loose_and_fixed())
    assert len([one for one in export(root / "library", root / "out") if one.model]) == 8
    return root / "out"


@pytest.fixture(scope="module")
def told(exported: Path) -> Any:
    return found_by("robosuite", "robosuite_objects.py", exported)


@pytest.fixture(scope="module")
def facts(exported: Path) -> dict[str, Any]:
    """Id -> what the export says of it."""
    return {row["id"]: row for row in json.loads((exported / "export.json").read_text())["assets"]}


def named(row: dict[str, Any]) -> str:
    return Path(row["path"]).parent.name


def test_all_are_found_by_their_registries(told: Any, facts: dict[str, Any], exported: Path) -> None:
    lists = told["registered"]
    sides = {name: {Path(p).parent.name for own in lists[name].values() for p in own} for name in lists}
    assert sides["casa"] == facts.keys()
    assert sides["casa_train"] | sides["casa_test"] == facts.keys()
    assert sides["casa_train"] & sides["casa_test"] == set()
    splits = json.loads((exported / "splits.json").read_text())
    for name in ("train", "test"):
        assert sorted(sides[f"casa_{name}"]) == splits[name]


def test_masses_survive_the_density_that_is_forced_on_them_and_both_generations_find_the_size(
    told: Any, facts: dict[str, Any]
) -> None:
    assert [named(row) for row in told["half"] if row["mass"] != pytest.approx(facts[named(row)]["mass_kg"])] == []
    for row in told["lying"]:
        assert row["mass"] == pytest.approx(facts[named(row)]["mass_kg"], rel=1e-5), row
        assert row["size_v0_2"] == pytest.approx(facts[named(row)]["size_m"], abs=1e-5)
        assert row["size_v1_0"] == pytest.approx(facts[named(row)]["size_m"], abs=0.011)  # of what collides
    for whole, half in zip(told["lying"], told["half"], strict=True):
        assert np.array(half["size_v1_0"]) == pytest.approx(np.array(whole["size_v1_0"]) / 2, rel=1e-6)


def test_placed_they_stay_where_they_are_and_nothing_is_warned_of(told: Any) -> None:
    assert (told["robosuite"], told["left"], told["warnings"]) == ("1.5.2", [], [])
    for row in told["lying"]:
        assert row["finite"]
        assert row["moved_m"] < 0.002, row
        assert row["fell_m"] == pytest.approx(0.01, abs=0.001), row
        # An orange rolls about its middle.
        assert row["turned"] < 0.02 or named(row).startswith("orange"), row


def test_what_lies_can_be_stood_up(told: Any) -> None:
    sizes = {named(row): row["size"] for row in told["stood"]}
    slices = ["sandwich_bread_0000000100", "sandwich_bread_0000000500"]
    assert sorted(name for name in sizes if name.startswith("sandwich_bread")) == slices
    assert sizes[slices[0]] == pytest.approx([0.014, 0.12, 0.11])
