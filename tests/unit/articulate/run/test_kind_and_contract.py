"""What a mesh is called, by the user, its look, its name or its shape, and what it lacks of its kind's contract."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.articulate.plan import Articulation
from casa_assets.articulate.run.acceptance import MAX_LISTED_FAULTS, unmet_checks, without_contract
from casa_assets.articulate.run.build import NAMING_CONFIDENCE, guess_category
from casa_assets.errors import UnknownId
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.places import Found
from casa_assets.library.clip import NO_WEIGHTS
from casa_assets.model.asset.asset import Asset
from casa_assets.model.record import Vec3
from tests.support.asset.assets import category
from tests.support.asset.contract_fixtures import hob, oven
from tests.support.asset.packages import packed
from tests.unit.articulate.blocks import drawers
from tests.unit.articulate.fragmented import found_on
from tests.unit.articulate.test_assemble import obj


def one(folder: Path, name: str) -> Found:
    (found,) = discover([obj(folder / name, *drawers()[:2])])
    assert isinstance(found, Found)
    return found


@pytest.fixture(scope="module")
def chest() -> tuple[Vec3, Articulation]:
    vertices, faces, _ = drawers()
    x, y, z = (float(v) for v in np.ptp(vertices, axis=0))
    return (x, y, z), found_on(vertices, faces)


def toaster() -> tuple[str, float, str]:
    return "toaster", 0.8, "CLIP says a toaster"


def nothing() -> tuple[str, float, str]:
    return "", 0.2, "CLIP says a kettle at 20%, which names nothing"


def test_the_user_goes_before_a_look_a_name_and_the_shape(tmp_path: Path, chest: tuple[Vec3, Articulation]) -> None:
    fridge, unnamed = one(tmp_path, "fridge.obj"), one(tmp_path, "mesh_0042.obj")
    kind = guess_category(fridge, *chest, stated="dishwasher", classify_by_image=toaster)
    assert (kind.id, kind.confidence) == ("dishwasher", 1.0)
    with pytest.raises(UnknownId):
        guess_category(fridge, *chest, stated="spaceship")
    kind = guess_category(fridge, *chest, classify_by_image=toaster)
    assert (kind.id, kind.confidence, kind.reason) == ("toaster", 0.8, "CLIP says a toaster")
    for seen in (None, nothing):
        named = guess_category(fridge, *chest, classify_by_image=seen)
        assert (named.id, named.reason[:11]) == ("refrigerator", "by its name")
    assert named.confidence >= NAMING_CONFIDENCE
    assert guess_category(fridge, *chest, stated="refrigerator") == guess_category(fridge, *chest), "it stays a guess"
    kind = guess_category(unnamed, *chest)
    assert kind.id == "drawer_stack"
    assert 0.2 < kind.confidence <= 0.6
    assert "by its shape and parts" in kind.reason
    assert NO_WEIGHTS in kind.reason
    assert "names nothing" in guess_category(unnamed, *chest, classify_by_image=nothing).reason


def faults(asset: Asset, folder: Path) -> tuple[str, ...]:
    known = registry.load()
    contract = known.contracts.get(asset.contract or "")
    return unmet_checks(asset, category(asset), packed(asset, folder).root, contract, known.limits)


def test_an_asset_lacks_nothing_of_its_contract_or_says_what(tmp_path: Path) -> None:
    assert faults(hob(), tmp_path / "whole") == ()
    renamed = tuple(c.replace(name="key") if c.name == "start_button" else c for c in oven().root.colliders)
    nameless = oven().replace(links=(oven().root.replace(colliders=renamed), *oven().links[1:]), behavior=None)
    assert any(f.startswith("CON003 colliders/start_button") for f in faults(nameless, tmp_path / "nameless"))
    stiff = hob().replace(joints=tuple(j.replace(damping=500.0) for j in hob().joints))
    found = faults(stiff, tmp_path / "stiff")
    assert found
    assert all(f.startswith("KIN") for f in found), "what does not move is said once the names are right"
    asset = without_contract(hob(), tuple(f"CON001 joints/k{i}: is not there" for i in range(MAX_LISTED_FAULTS + 2)))
    guess = asset.provenance.guesses[-1]
    assert (asset.contract, guess.subject, guess.value) == (None, "contract", "not stovetop")
    assert guess.reason.endswith("and 2 more")
