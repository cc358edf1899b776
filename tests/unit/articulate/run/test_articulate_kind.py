"""Who says what a mesh is: the user, its look, its name, its shape and parts, in this order."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets.articulate.plan import Articulation
from casa_assets.articulate.run.build import NAMING_CONFIDENCE, guess_category
from casa_assets.errors import UnknownId
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found
from casa_assets.library.clip import NO_WEIGHTS
from casa_assets.model.record import Vec3
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


def test_the_user_goes_before_all(tmp_path: Path, chest: tuple[Vec3, Articulation]) -> None:
    kind = guess_category(one(tmp_path, "fridge.obj"), *chest, stated="dishwasher", classify_by_image=toaster)
    assert (kind.id, kind.confidence) == ("dishwasher", 1.0)
    with pytest.raises(UnknownId):
        guess_category(one(tmp_path, "fridge.obj"), *chest, stated="spaceship")


def test_a_look_goes_before_a_name(tmp_path: Path, chest: tuple[Vec3, Articulation]) -> None:
    kind = guess_category(one(tmp_path, "fridge.obj"), *chest, classify_by_image=toaster)
    assert (kind.id, kind.confidence, kind.reason) == ("toaster", 0.8, "CLIP says a toaster")


def test_a_name_goes_before_the_shape(tmp_path: Path, chest: tuple[Vec3, Articulation]) -> None:
    for seen in (None, nothing):
        kind = guess_category(one(tmp_path, "fridge.obj"), *chest, classify_by_image=seen)
        assert kind.id == "refrigerator"
        assert kind.reason.startswith("by its name")


def test_the_shape_names_what_nothing_else_does(tmp_path: Path, chest: tuple[Vec3, Articulation]) -> None:
    mesh = one(tmp_path, "mesh_0042.obj")
    kind = guess_category(mesh, *chest)
    assert kind.id == "drawer_stack"
    assert 0.2 < kind.confidence <= 0.6
    assert "by its shape and parts" in kind.reason
    assert NO_WEIGHTS in kind.reason
    assert "names nothing" in guess_category(mesh, *chest, classify_by_image=nothing).reason


def test_a_word_that_repeats_a_sure_guess_leaves_it_one(tmp_path: Path, chest: tuple[Vec3, Articulation]) -> None:
    named = guess_category(one(tmp_path, "fridge.obj"), *chest)
    assert named.confidence >= NAMING_CONFIDENCE
    assert guess_category(one(tmp_path, "fridge.obj"), *chest, stated="refrigerator") == named
