"""A fault of the program in one item of a batch: its trace is told, the others go on, and the run ends with exit 3."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from casa_assets.asset.family import Params
from casa_assets.errors import CasaError
from casa_assets.families import build as families
from casa_assets.families.asset_store import AssetStore
from casa_assets.ingest.run import steps as worker
from casa_assets.layouts.run import resolve
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.runs.engine import attempt
from tests.support.library.libraries import BOXES, box_obj, called


@pytest.fixture
def faulty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Building a vase, and reading a milk carton, meet a fault."""
    build, collect = families.build_asset, worker.collect

    def faulty_build(found: Any, *rest: Any) -> Any:
        assert found.name != "vase", "a vase without a bottom"
        return build(found, *rest)

    def faulty_collect(found: Any, limits: Any) -> Any:
        assert "milk" not in found.main, "a carton without a lid"
        return collect(found, limits)

    monkeypatch.setattr(families, "build_asset", faulty_build)
    monkeypatch.setattr(worker, "collect", faulty_collect)


@pytest.mark.usefixtures("faulty")
def test_of_a_family(tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = called("families", "build", "vase", "switch", "--samples", 1, "--no-pictures", "--library", out, "--json")
    assert done.returncode == 3, done.stderr
    said = {row["member"]: row for row in map(json.loads, done.stdout.splitlines())}
    assert said["switch/#0"]["passed"]
    assert "AssertionError: a vase without a bottom" in said["vase/#0"]["message"]
    assert "Traceback" in said["vase/#0"]["message"]
    assert "vase/#0: a fault of the program" in done.stderr


@pytest.mark.usefixtures("faulty")
def test_of_an_input(tmp_path: Path) -> None:
    for name in ("cereal_box", "milk_carton"):
        (tmp_path / f"{name}.obj").write_text(box_obj(BOXES[name]), encoding="ascii")
    done = called("ingest", *tmp_path.glob("*.obj"), "--library", tmp_path / "library", "--json")
    assert done.returncode == 3, done.stderr
    said = {row["path"]: row for row in map(json.loads, done.stdout.splitlines())}
    assert said["cereal_box.obj"]["status"] == "accepted"
    assert said["milk_carton.obj"]["code"] == "RUN004"
    assert "AssertionError: a carton without a lid" in said["milk_carton.obj"]["message"]


@pytest.mark.parametrize(("error", "is_fault"), [(CasaError("too wide"), False), (ValueError("too wide"), True)])
def test_who_is_to_blame(error: Exception, is_fault: bool, tmp_path: Path) -> None:
    def fail() -> tuple[str, bool]:
        raise error

    message, told = attempt(fail, lambda text, fault: (text, fault), tmp_path)
    assert told == is_fault
    assert message == "too wide" or (is_fault and message.startswith("Traceback"))


def test_a_value_error_of_a_builder_is_no_mistake_of_the_user(tmp_path: Path) -> None:
    class Broken(AssetStore):
        def built(self, found: object, params: Params) -> Asset:
            raise ValueError("a box needs a positive size")

    with pytest.raises(ValueError, match="positive size"):
        resolve.build_choice("sink", PresetChoice(preset="vase/white_tulips"), Broken(tmp_path))
