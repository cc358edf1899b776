"""The swift way to run SimReady's rules finds what SimReady finds by itself."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from pxr import Ar, Usd, UsdGeom, UsdShade

from casa_assets.checks.package import Package
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.simready import load_rules, validate
from tests.support.asset.assets import microwave, rigid_mug
from tests.support.asset.packages import tamper, written

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def kit() -> ModuleType:
    """What is made of SimReady's own classes."""
    from tests.support.asset import simready_rules

    return simready_rules


@pytest.fixture
def stage() -> Usd.Stage:
    found = Usd.Stage.CreateInMemory()
    for name in ("a", "bad", "b"):
        UsdGeom.Xform.Define(found, f"/{name}")
    return found


@pytest.fixture
def their_way(kit: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """Meanwhile SimReady runs as it does by itself."""
    load_rules()
    checker, plain = kit.Checker, kit.TheirRunner

    def create(cls: Any, rules: Any, stats: Any, context: Any, *, processes: int = 0) -> Any:
        return plain(rules=rules, stats=stats, processes=processes, context=context)

    monkeypatch.setattr(checker, kit.simready.MAKE_RUNNER, classmethod(create))
    monkeypatch.setattr(kit.simready, "only_demanded", lambda without: nullcontext())


def test_each_rule_is_given_what_it_looks_at_in_order(kit: ModuleType, stage: Usd.Stage) -> None:
    """What a rule cannot bear is a finding of it."""
    looker, stager = kit.Looker(), kit.Stager()
    with kit.simready.DirectRunner([looker, stager], Ar.GetResolver().GetCurrentContext()) as runner:
        for event in kit.events(stage):
            runner.append(event)
    assert looker.seen == ["a", "bad", "b"]
    assert [issue.message for issue in looker.GetIssues()] == ["Uncaught error: too much"]
    assert [issue.message for issue in stager.GetIssues()] == ["a stage"]


class TestDirectRunner:
    def test_a_rule_does_not_look_for_what_is_not_demanded(self, kit: ModuleType, stage: Usd.Stage) -> None:
        def found() -> list[str]:
            rule = kit.Two()
            with kit.simready.DirectRunner([rule], Ar.GetResolver().GetCurrentContext()) as runner:
                runner.append(kit.Event(kit.Kind.PRIM, stage.GetPrimAtPath("/a")))
            return [issue.message for issue in rule.GetIssues()]

        demanded = kit.simready._demanded.set(frozenset({"com.nvidia.simready.VM.TEX.001"}))
        some = found()
        kit.simready._demanded.reset(demanded)
        assert some == ["size of a"]
        assert found() == ["size of a", "surface of a"], "where nobody says what is demanded"


def unnamed(package: Package) -> None:
    tamper(package.usd, ('string author = "Casa"', 'string author = ""'))


def upside_down(package: Package) -> None:
    tamper(package.usd, ('upAxis = "Z"', 'upAxis = "Y"'))


def bound_otherwise(package: Package) -> None:
    """A mesh that is bound by collection, another with a strong binding, a third that is bound to nothing."""
    stage = Usd.Stage.Open(str(package.usd))
    meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    for name, prim in zip(("collected", "strong", "bare"), (meshes[0],) * 3, strict=True):
        mesh = UsdGeom.Mesh.Define(stage, prim.GetParent().GetPath().AppendChild(name))
        for attribute in prim.GetAuthoredAttributes():
            mesh.GetPrim().CreateAttribute(attribute.GetName(), attribute.GetTypeName()).Set(attribute.Get())
        api = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if name == "collected":
            kept = Usd.CollectionAPI.Apply(mesh.GetPrim(), "kept")
            api.Bind(kept, material, "kept")
        if name == "strong":
            api.Bind(material, UsdShade.Tokens.strongerThanDescendants)
    stage.Save()


FAULTS = {
    "sound": lambda package: None,
    "unnamed": unnamed,
    "upside-down": upside_down,
    "bound-otherwise": bound_otherwise,
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("asset", [rigid_mug, microwave])
def test_both_ways_give_one_verdict(asset: Any, fault: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    package = written(asset(), tmp_path)
    FAULTS[fault](package)
    with quiet():
        swift = validate(package.usd)
        request.getfixturevalue("their_way")
        theirs = validate(package.usd)
    assert swift == theirs
    assert swift is not None
    assert swift[0] is (fault == "sound")


def test_requirements_that_do_not_count_need_not_be_met(kit: ModuleType, tmp_path: Path) -> None:
    package = written(rigid_mug(), tmp_path)
    unnamed(package)
    with quiet():
        found = validate(package.usd)
        assert found is not None
        (code,) = found[1]
        assert validate(package.usd, frozenset({code})) == (True, {})
    assert kit.simready_api._bucket_requirements_by_runtime.__module__ == kit.simready_api.__name__, "it is put back"
