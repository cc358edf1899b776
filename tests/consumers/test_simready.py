"""The swift ways to run SimReady find what it finds by itself, in this process, by another Python, once a layer."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from pxr import Gf, Usd, UsdGeom, UsdShade

from casa_assets.checks import simready
from casa_assets.checks.check import Package
from casa_assets.checks.package import usd
from casa_assets.checks.scene import formats as usd_layer
from casa_assets.checks.simready import load_rules, quiet, validate, validate_simready
from casa_assets.checks.simready_python import VARIABLE, versions_elsewhere
from casa_assets.layouts.run.check import PassedLayers
from casa_assets.model.asset.asset import Base
from tests.support.asset.assets import microwave, rigid_mug, textured_box
from tests.support.asset.cupboard import cupboard
from tests.support.asset.packages import Tampering, tamper, written
from tests.support.kitchen.rooms import at, block, in_all_forms, room
from tests.support.library.libraries import ran

pytestmark = pytest.mark.consumers


@pytest.fixture
def their_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """Meanwhile SimReady runs as it does by itself."""
    from tests.support.asset import simready_rules as kit  # of SimReady's own classes

    load_rules()
    checker, plain = kit.Checker, kit.TheirRunner

    def create(cls: Any, rules: Any, stats: Any, context: Any, *, processes: int = 0) -> Any:
        return plain(rules=rules, stats=stats, processes=processes, context=context)

    monkeypatch.setattr(checker, kit.simready.MAKE_RUNNER, classmethod(create))
    monkeypatch.setattr(kit.simready, "only_demanded", lambda without: nullcontext())


def unnamed(package: Package) -> None:
    tamper(package.usd, ('string author = "Casa"', 'string author = ""'))


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
    "upside-down": lambda package: tamper(package.usd, ('upAxis = "Z"', 'upAxis = "Y"')),
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


CORNERS = ((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.4, 0.0), (0.0, 0.0, 0.5))
FACES = (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
Vec = tuple[float, float, float]
HERE: Vec = (0.0, 0.0, 0.0)


def stage_of(
    moved: Vec = HERE, off: Vec = HERE, faces: tuple[int, ...] = FACES, turned: float = 0.0, hidden: bool = False
) -> Usd.Stage:
    """Two wedges, the second of them placed, shaped, turned (degrees) or hidden otherwise."""
    stage = Usd.Stage.CreateInMemory()
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    for name, place, by, corners, angle in (("a", HERE, HERE, FACES, 0.0), ("b", moved, off, faces, turned)):
        mesh = UsdGeom.Mesh.Define(stage, f"/World/{name}")
        mesh.CreatePointsAttr([Gf.Vec3f(*(c + o for c, o in zip(corner, by, strict=True))) for corner in CORNERS])
        mesh.CreateFaceVertexCountsAttr([3] * (len(corners) // 3))
        mesh.CreateFaceVertexIndicesAttr(corners)
        mesh.AddTranslateOp().Set(Gf.Vec3d(*place))
        mesh.AddRotateZOp().Set(angle)
    if hidden:
        mesh.MakeInvisible()
    return stage


def verdicts(stage: Usd.Stage) -> tuple[int, int]:
    from tests.support.asset.simready_rules import registered, simready

    swift = registered(simready.COINCIDENT)
    theirs = swift.__mro__[1]
    assert swift.__name__ == "CoincidentMeshes"
    assert theirs.__module__.startswith("simready.")
    found = []
    for kind in (theirs, swift):
        rule = kind()
        rule.CheckStage(stage)
        found.append(len(rule.GetIssues()))
    return found[0], found[1]


@pytest.mark.parametrize(
    ("stage", "found"),
    [
        pytest.param(stage_of(), 1, id="the-same-twice"),
        pytest.param(stage_of(off=(2e-8, 0.0, 0.0)), 1, id="points-that-round-to-the-same"),
        pytest.param(stage_of(moved=(2e-5, 0.0, 0.0)), 1, id="places-that-round-to-the-same"),
        pytest.param(stage_of(off=(1e-5, 0.0, 0.0)), 0, id="other-points"),
        pytest.param(stage_of(moved=(0.0, 0.0, 0.001)), 0, id="a-millimetre-higher"),
        pytest.param(stage_of(turned=90.0), 0, id="turned"),
        pytest.param(stage_of(faces=FACES[3:] + FACES[:3]), 0, id="faces-in-another-order"),
        pytest.param(stage_of(hidden=True), 0, id="the-other-is-hidden"),
        pytest.param(Usd.Stage.CreateInMemory(), 0, id="nothing-at-all"),
    ],
)
def test_both_find_the_same(stage: Usd.Stage, found: int) -> None:
    assert verdicts(stage) == (found, found)


@pytest.mark.parametrize("corrupt", [None, unnamed], ids=["good", "bad"])
def test_verdict_is_that_of_the_command_line(corrupt: Tampering | None, tmp_path: Path) -> None:
    package = written(microwave(), tmp_path)
    if corrupt:
        corrupt(package)
    validator, profile = Path(sys.executable).with_name("simready-validate"), ("--profile", simready.PROFILE)
    ran(validator, *profile, "--version", simready.PROFILE_VERSION, package.usd, code=int(bool(corrupt)), cwd=tmp_path)
    assert (usd.usd_meets_simready_profile(package).problems == ()) == (corrupt is None)


def test_a_file_of_the_user_that_hides_one_of_its_modules_is_named(tmp_path: Path) -> None:
    (tmp_path / "usd.py").write_text("raise OSError\n")
    script = tmp_path / "look.py"
    script.write_text("from casa_assets.checks.simready import load_rules\nload_rules()\n")
    done = ran(sys.executable, script, code=None)
    assert "CasaError" in done.stderr
    assert f"usd.py, may be in {tmp_path}: rename it" in done.stderr


@pytest.mark.parametrize(
    "above", ["Küche 空 1", "-x", "CON", f"{'a' * 120}/{'a' * 120}"], ids=["words", "dash", "reserved", "long"]
)
def test_where_a_library_lies_does_not_matter(above: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = written(microwave(), tmp_path / above)
    assert validate_simready(package.usd, package.root) == (True, {})
    inside = package.usd.rename(package.usd.with_name("micro wave.usda"))
    assert "com.nvidia.simready.NP.002" in validate_simready(inside, package.root)[1]


def test_another_python_gives_the_same_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good, bad = written(rigid_mug(), tmp_path / "good"), written(rigid_mug(), tmp_path / "bad case")
    unnamed(bad)
    codes = frozenset({"com.nvidia.simready.SR.004"})
    asked = [(good, frozenset[str]()), (bad, frozenset[str]()), (bad, codes)]
    here = [validate_simready(one.usd, one.root, without) for one, without in asked]
    assert [passes for passes, _ in here] == [True, False, True]
    assert versions_elsewhere() == {}
    monkeypatch.setenv(VARIABLE, sys.executable)
    assert [validate_simready(one.usd, one.root, without) for one, without in asked] == here
    assert {"simready-validate", "simready-foundation-tier-core"} <= versions_elsewhere().keys()


CRATE = block("crate", (0.2, 0.2, 0.2), Base.FREE)  # which stands by its weight


@pytest.fixture
def looked_at(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Number of placements in each file that the validator was given."""
    counts: list[int] = []
    validate = usd_layer.validate_simready

    def counted(path: Path, folder: Path, without: frozenset[str]) -> tuple[bool, dict[str, str]]:
        stage = Usd.Stage.Open(str(path))
        counts.append(len([prim for prim in stage.GetDefaultPrim().GetChildren() if prim.GetPrimAtPath("object")]))
        return validate(path, folder, without)

    monkeypatch.setattr(usd_layer, "validate_simready", counted)
    return counts


def test_what_passed_is_left_out_of_the_next_kitchen(tmp_path: Path, looked_at: list[int]) -> None:
    known = PassedLayers(tmp_path / "cache")
    first = room((CRATE, at(0, 0, 0)), (CRATE, at(1, 0, 0)), (textured_box(), at(0.5, 0, 0)))
    second = room((CRATE, at(0, 0, 0)), (cupboard(), at(1, 0, 0)))
    for number, scene in enumerate((first, second)):
        files = replace(in_all_forms(scene, tmp_path / str(number)), passed_layers=known)
        assert usd_layer.usd_scene_meets_simready_rules(files).number == 0
    # The floor, one of two crates and the box; then the smallest of what is known, for a body, and the cupboard.
    assert looked_at == [3, 2]
    assert list(tmp_path.glob("*/**/.*usda")) == []


def test_a_fault_is_found_beside_what_is_known(tmp_path: Path, looked_at: list[int]) -> None:
    known = PassedLayers(tmp_path / "cache")
    for number in range(2):
        things = room((CRATE, at(0, 0, 0)), (textured_box(), at(0.5, 0, 0)))
        files = replace(in_all_forms(things, tmp_path / str(number)), passed_layers=known)
        if number:
            tamper(files.usd, ("metersPerUnit = 1", "metersPerUnit = 0.01"))
        found = usd_layer.usd_scene_meets_simready_rules(files)
    assert found.number == 1
    assert len(looked_at) == 3, "the whole file is looked at where a part of it fails"
