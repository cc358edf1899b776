"""SimReady's rules look once at each layer of an asset, in whatever kitchen it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from pxr import Usd

from casa_assets.checks.scene import forms
from casa_assets.checks.scene.forms import SceneFiles
from casa_assets.layouts.run.check import PassedLayers
from casa_assets.model.asset.asset import Base
from casa_assets.model.kitchen.scene import Scene
from tests.support.asset.assets import textured_box
from tests.support.asset.cupboard import cupboard
from tests.support.asset.packages import tamper
from tests.support.kitchen.rooms import at, block, in_all_forms, room

pytestmark = pytest.mark.consumers


def things() -> Scene:
    """A crate that stands by its weight, and a box with pictures."""
    crate = block("crate", (0.2, 0.2, 0.2), Base.FREE)
    return room((crate, at(0.0, 0.0, 0.0)), (textured_box(), at(0.5, 0.0, 0.0)))


@pytest.fixture
def looked_at(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Number of placements in each file that the validator was given."""
    counts: list[int] = []
    validate = forms.validate_simready

    def counted(path: Path, folder: Path, without: frozenset[str]) -> tuple[bool, dict[str, str]]:
        stage = Usd.Stage.Open(str(path))
        counts.append(len([prim for prim in stage.GetDefaultPrim().GetChildren() if prim.GetPrimAtPath("object")]))
        return validate(path, folder, without)

    monkeypatch.setattr(forms, "validate_simready", counted)
    return counts


def test_what_passed_is_left_out_of_the_next_kitchen(tmp_path: Path, looked_at: list[int]) -> None:
    known = PassedLayers(tmp_path / "cache")
    crate = block("crate", (0.2, 0.2, 0.2), Base.FREE)
    first = room((crate, at(0, 0, 0)), (crate, at(1, 0, 0)), (textured_box(), at(0.5, 0, 0)))
    second = room((crate, at(0, 0, 0)), (cupboard(), at(1, 0, 0)))
    for number, scene in enumerate((first, second)):
        files = replace(in_all_forms(scene, tmp_path / str(number)), passed_layers=known)
        assert forms.usd_scene_meets_simready_rules(files).number == 0
    # The floor, one of two crates and the box; then the smallest of what is known, for a body, and the cupboard.
    assert looked_at == [3, 2]
    assert list(tmp_path.glob("*/**/.*usda")) == []


def test_a_fault_is_found_beside_what_is_known(tmp_path: Path, looked_at: list[int]) -> None:
    known = PassedLayers(tmp_path / "cache")
    for number in range(2):
        files = replace(in_all_forms(things(), tmp_path / str(number)), passed_layers=known)
        if number:
            tamper(files.usd, ("metersPerUnit = 1", "metersPerUnit = 0.01"))
        found = forms.usd_scene_meets_simready_rules(files)
    assert found.number == 1
    assert len(looked_at) == 3, "the whole file is looked at where a part of it fails"


def test_a_layer_that_changed_is_looked_at_again(tmp_path: Path) -> None:
    known = PassedLayers(tmp_path / "cache")
    files = replace(in_all_forms(things(), tmp_path / "room"), passed_layers=known)
    assert forms.usd_scene_meets_simready_rules(files).number == 0
    (layer,) = files.usd.parent.parent.glob("assets/usd/crate*/crate*.usda")
    tamper(layer, ("metersPerUnit = 1", "metersPerUnit = 1  # changed"))
    again = replace(SceneFiles(files.scene_subject), passed_layers=known)
    digest = forms._digest(layer.read_bytes())
    assert not known.has(digest)
    assert forms.usd_scene_meets_simready_rules(again).number == 0
    assert known.has(digest)
