"""Every preset of the fixtures that RoboCasa v1.0 loads from files, operated by its own classes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from casa_assets import registry
from casa_assets.families.build import build_asset
from casa_assets.formats import mjcf
from casa_assets.kitchenware.catalog import MODELS
from casa_assets.model.registry.contract import RobocasaRelease
from casa_assets.registry.families import family
from tests.support.asset.assets import write_to
from tests.support.program.environments import found_by

KNOWN = registry.load()
# Classes that do something. A lid is operated with the blender of its name.
OPERATED = (
    *("Blender", "CoffeeMachine", "DishRack", "Dishwasher", "ElectricKettle", "Fridge", "FridgeBottomFreezer"),
    *("FridgeFrenchDoor", "FridgeSideBySide", "Hood", "Microwave", "Oven", "Sink", "StandMixer", "Stove", "Stovetop"),
    *("Toaster", "ToasterOven"),
)
LID = "blender_lid"

pytestmark = pytest.mark.consumers


def class_of(family_name: str) -> str:
    """The first class of RoboCasa v1.0 that reads members of a family; empty where there is none."""
    contract = KNOWN.contracts.get(MODELS[family_name].contract or "")
    return (contract.read_by.get(RobocasaRelease.V1_0, ("",)) if contract else ("",))[0]


FAMILIES = tuple(name for name in MODELS if class_of(name) in OPERATED)


def written(name: str, root: Path, cache: Path) -> list[dict[str, str]]:
    """Writes every preset of a family; returns what operate_fixtures.py is told of them."""
    rows = []
    for preset, params in family(name).presets.items():
        folder = f"{name}__{preset}"
        write_to(mjcf.write(build_asset(family(name), params, cache)), root / folder)
        rows.append({"name": folder, "class": class_of(name), "folder": folder})
        if class_of(name) == "Blender":
            rows[-1]["lid"] = f"{LID}__{preset}"
    return rows


def operated(rows: Sequence[dict[str, str]], root: Path) -> dict[str, Any]:
    classes = sorted({c for k in KNOWN.contracts.values() for c in k.read_by.get(RobocasaRelease.V1_0, ())})
    task = root / f"{rows[0]['name']}.json"
    task.write_text(json.dumps({"fixtures": rows, "classes": classes}), encoding="ascii")
    return dict(found_by("robocasa", "robocasa/operate_fixtures.py", task, timeout_s=900))


@pytest.fixture(scope="module")
def told(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    root = tmp_path_factory.mktemp("robocasa_fixtures")
    with ProcessPoolExecutor(2) as workers:
        families = list(workers.map(partial(written, root=root, cache=cache), (*FAMILIES, LID)))
    rows = [row for name, found in zip(FAMILIES, families, strict=False) for row in found]
    with ThreadPoolExecutor(2) as threads:
        return list(threads.map(partial(operated, root=root), (rows[::2], rows[1::2])))


def test_every_preset_does_what_its_class_asks_of_it(told: list[dict[str, Any]]) -> None:
    found = {row["name"]: row["wrong"] for half in told for row in half["fixtures"]}
    assert {name: wrong for name, wrong in found.items() if wrong} == {}
    assert len(found) == sum(len(family(name).presets) for name in FAMILIES) == 188
    assert {half["mujoco"] for half in told} == {"3.3.1"}, "RoboCasa's own"


def test_contracts_say_which_classes_load_no_file(told: list[dict[str, Any]]) -> None:
    for contract in KNOWN.contracts.values():
        loads = [told[0]["takes_file"][name] for name in contract.read_by.get(RobocasaRelease.V1_0, ())]
        assert all(taken != contract.by_subclass for taken in loads), contract.id
