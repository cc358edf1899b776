"""An asset names the contract that it holds, and says what is missing where it holds none."""

from __future__ import annotations

from pathlib import Path

from casa_assets import registry
from casa_assets.articulate.run.acceptance import MAX_LISTED_FAULTS, unmet_checks, without_contract
from casa_assets.model.asset.asset import Asset
from tests.support.asset.assets import category
from tests.support.asset.contract_fixtures import hob, oven
from tests.support.asset.packages import packed

KNOWN = registry.load()


def faults(asset: Asset, folder: Path) -> tuple[str, ...]:
    contract = KNOWN.contracts.get(asset.contract or "")
    return unmet_checks(asset, category(asset), packed(asset, folder).root, contract, KNOWN.limits)


def test_what_holds_its_contract_lacks_nothing(tmp_path: Path) -> None:
    assert faults(hob(), tmp_path) == ()


def test_names_that_are_missing_are_said(tmp_path: Path) -> None:
    plain = oven()
    renamed = tuple(c.replace(name="key") if c.name == "start_button" else c for c in plain.root.colliders)
    asset = plain.replace(links=(plain.root.replace(colliders=renamed), *plain.links[1:]), behavior=None)
    found = faults(asset, tmp_path)
    assert any(f.startswith("CON003 colliders/start_button") for f in found)


def test_what_does_not_move_is_said_once_the_names_are_right(tmp_path: Path) -> None:
    plain = hob()
    stiff = plain.replace(joints=tuple(j.replace(damping=500.0) for j in plain.joints))
    found = faults(stiff, tmp_path)
    assert found
    assert all(f.startswith("KIN") for f in found)


def test_an_asset_without_its_contract_keeps_the_reason() -> None:
    asset = without_contract(hob(), tuple(f"CON001 joints/k{i}: is not there" for i in range(MAX_LISTED_FAULTS + 2)))
    assert asset.contract is None
    guess = asset.provenance.guesses[-1]
    assert (guess.subject, guess.value) == ("contract", "not stovetop")
    assert guess.reason.endswith("and 2 more")
