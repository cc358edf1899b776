"""A library becomes a folder of objects whole or not at all; objects as RoboCasa's loaders read them."""

from __future__ import annotations

import ast
import json
import os
import shutil
import sys
from collections.abc import Callable
from inspect import Parameter, Signature
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from lxml import etree

from casa_assets import registry
from casa_assets.addons.robocasa import casa_kitchens, casa_objects, objects
from casa_assets.addons.robocasa.run import ExportResult, export
from casa_assets.errors import OutputError
from casa_assets.formats import mjcf
from casa_assets.library.entry_files import CERTIFICATE
from casa_assets.model.asset.asset import Asset, Joint, JointKind, Keyframe, Link, Split, split_of
from casa_assets.model.pose import Pose
from casa_assets.model.registry.contract import RobocasaRelease
from tests.support.asset.assets import ball, rigid_mug, textured_box, write_to
from tests.support.library.built_libraries import SLICE_SIZE, TEST, TRAIN, keep, loose_and_fixed, slice_of_bread
from tests.support.library.libraries import differences, tree

SLICES = [f"sandwich_bread_{digest[:10]}" for digest in (TRAIN, TEST)]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("library") / "lib", loose_and_fixed())


@pytest.fixture
def library(source: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(source, tmp_path / "lib"))


def run(library: Path, out: Path, name: str = "casa") -> list[ExportResult]:
    return list(export(library, out, name))


def test_every_loose_object_is_there_and_books_agree(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "out"
    every = run(library, out, "acme")
    (refused,) = (one for one in every if not one.model)
    assert (refused.id, "fixture" in refused.message) == ("microwave_0123456789", True)
    done = {one.id: one for one in every if one.model}
    models = sorted(path.relative_to(out).as_posix() for path in out.rglob("model.xml"))
    assert models == sorted(one.model for one in done.values())
    assert sorted(path.parent.name for path in out.rglob("model_upright.xml")) == SLICES
    assert {path.name for path in out.iterdir()} == {
        *("objects", "categories_v0_2.json", "categories_v1_0.json", "export.json", "splits.json"),
        *("casa_objects.py", "README.md", "ATTRIBUTION.md"),
    }
    assert [p.name for p in out.parent.iterdir()] == ["out"]
    rows = {row["id"]: row for row in json.loads((out / "export.json").read_text())["assets"]}
    splits = json.loads((out / "splits.json").read_text())
    assert rows.keys() == done.keys() == {*splits["train"], *splits["test"]}
    assert splits["train"] == [SLICES[0]]
    assert all(row["split"] == split_of(row["sha256"]).value for row in rows.values())
    row = rows[SLICES[0]]
    assert (row["mass_kg"], row["size_m"]) == (0.04, [0.12, 0.11, 0.0145])
    assert row["model"].startswith("objects/acme/sandwich_bread/")
    for generation in ("v0_2", "v1_0"):
        table = json.loads((out / f"categories_{generation}.json").read_text())
        assert set(table) == {row["category"] for row in rows.values()}
        assert table["mug"]["acme"]["model_folders"] == ["acme/mug"]
    assert "5 objects in 4 categories (1 train, 4 test)" in (out / "README.md").read_text()
    told = (out / "ATTRIBUTION.md").read_text()
    assert (SLICES[0] in told, "microwave" in told) == (True, False)


def test_the_same_library_gives_the_same_bytes_and_an_earlier_export_is_replaced(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "a"
    run(library, out)
    run(library, tmp_path / "b")
    assert differences(out, tmp_path / "b") == []
    shutil.rmtree(library / "mug")
    run(library, out)
    kept = {path.name for path in (out / "objects" / "casa").iterdir()}
    assert ("mug" in kept, "orange" in kept) == (False, True)


def test_an_instance_never_changes_sides(library: Path, tmp_path: Path) -> None:
    """Nor does its folder, whoever else comes or goes."""
    before = {one.id: (one.split, one.model) for one in run(library, tmp_path / "a")}
    keep(library, [slice_of_bread(f"{i:08x}" * 8) for i in range(20, 24)])
    after = {one.id: (one.split, one.model) for one in run(library, tmp_path / "b")}
    assert len(after) == len(before) + 4
    assert before.items() <= after.items()
    # Splits follow the digest alone.
    sides = [split_of(f"{i:08x}" + "0" * 56) for i in range(1000)]
    assert sides.count(Split.TEST) == 200
    assert (split_of(TRAIN), split_of(TEST)) == (Split.TRAIN, Split.TEST)


# What is done to the folder of an entry, and the file that is then complained of.
DAMAGES: dict[str, tuple[Callable[[Path], object], str]] = {
    "gone": (lambda folder: (folder / "model.xml").unlink(), "model.xml"),
    "changed": (lambda folder: (folder / "model.xml").write_text("<mujoco/>"), "model.xml"),
    "cut": (lambda folder: os.truncate(folder / CERTIFICATE, 200), CERTIFICATE),
    "no asset": (lambda folder: (folder / CERTIFICATE).write_text("{}"), CERTIFICATE),
    "moved": (lambda folder: folder.rename(folder.with_name("mug_other")), CERTIFICATE),
}


@pytest.mark.parametrize("how", DAMAGES)
def test_a_damaged_entry_is_named_and_nothing_is_written(library: Path, tmp_path: Path, how: str) -> None:
    out = tmp_path / "out"
    run(library, out)
    before = tree(out)
    damage, named = DAMAGES[how]
    damage(library / "mug" / "mug_0123456789")
    if how == "gone":
        out.rename(tmp_path / ".out.4194305.old")  # as a run leaves it that is killed between its two renames
    with pytest.raises(OutputError, match=named):
        run(library, out)
    assert tree(out) == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["lib", "out"]


def test_a_folder_that_is_no_library_or_holds_fixtures_alone(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    keep(tmp_path / "lib", [loose_and_fixed()[-1]])
    nothing = "holds no accepted asset"
    for folder, message in {"empty": nothing, "missing": nothing, "lib": "no loose object"}.items():
        with pytest.raises(OutputError, match=message):
            run(tmp_path / folder, tmp_path / "out")
    for name in ("", "Casa", "a/b", "..", "a__b", "1st", "a b"):
        with pytest.raises(OutputError, match="no name of a registry"):
            list(export(None, tmp_path / "out", name))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["empty", "lib"]


def test_what_is_not_ours_is_left_alone(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(library, out)
    (out / "__pycache__").mkdir()
    run(library, out)
    assert not (out / "__pycache__").exists()
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"notes\.txt"):
        run(library, out)
    assert (out / "notes.txt").read_text() == "mine"
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "cat.png").write_bytes(b"cat")
    (tmp_path / "file").write_bytes(b"mine")
    (tmp_path / "link").symlink_to(tmp_path / "photos")
    for place in ("photos", "file", "link", "lib", "lib/sub", "."):
        with pytest.raises(OutputError, match="name another"):
            run(library, tmp_path / place)
    assert (tmp_path / "photos" / "cat.png").read_bytes() == b"cat"
    assert (tmp_path / "file").read_bytes() == b"mine"


def test_a_run_that_is_broken_off_leaves_nothing_and_what_a_killed_one_left_is_swept(
    library: Path, tmp_path: Path
) -> None:
    running = export(library, tmp_path / "out")
    next(running)
    assert len(list(tmp_path.iterdir())) == 2
    running.close()
    assert [p.name for p in tmp_path.iterdir()] == ["lib"]
    (tmp_path / ".out.4194305").mkdir()  # above the greatest number that Linux gives a process
    run(library, tmp_path / "out")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["lib", "out"]


EVERY = (rigid_mug, ball, textured_box, slice_of_bread)


def parsed(asset: Asset, file: str = objects.FILE) -> etree._Element:
    return etree.fromstring(objects.write(asset, stood_up=True).entries[file])


def compiled(asset: Asset, folder: Path, file: str = objects.FILE) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(write_to(objects.write(asset, stood_up=True), folder) / file))


def seen(found: mujoco.MjModel) -> np.ndarray:
    """(2, 3) corners of the meshes of group 1, world frame, metres."""
    data = mujoco.MjData(found)
    mujoco.mj_forward(found, data)
    points = []
    for i in range(found.ngeom):
        if found.geom_group[i] == 1 and found.geom_type[i] == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = found.geom_dataid[i]
            start = found.mesh_vertadr[mesh]
            local = found.mesh_vert[start : start + found.mesh_vertnum[mesh]]
            points.append(local @ data.geom_xmat[i].reshape(3, 3).T + data.geom_xpos[i])
    cloud = np.concatenate(points)
    return np.array([cloud.min(axis=0), cloud.max(axis=0)])


def test_lids_are_shut_for_good(tmp_path: Path) -> None:
    """RoboCasa places an object by the first of its joints, which has to be the free one that robosuite adds."""
    mug = rigid_mug()
    lid = Link(name="lid", parent="object", pose=Pose(position=(0.0, 0.0, 0.1)), inertial=mug.root.inertial)
    joint = Joint(name="lid_joint", kind=JointKind.SLIDE, child="lid", axis=(0.0, 0.0, 1.0), range=(0.0, 0.1))
    jar = mug.replace(links=(*mug.links, lid), joints=(joint,), keyframes=(Keyframe(name="closed"),))
    assert parsed(jar).findall(".//joint") == []
    found = compiled(jar, tmp_path)
    assert found.njnt == 0
    assert sum(found.body_mass) == pytest.approx(2 * mug.mass)


@pytest.mark.parametrize("build", EVERY)
@pytest.mark.parametrize("file", [objects.FILE, objects.UPRIGHT_FILE])
def test_a_model_is_laid_out_as_loaders_walk(build: Callable[[], Asset], file: str) -> None:
    root = parsed(build(), file)
    [outer] = root.findall("worldbody/body")
    assert outer.get("name") is None
    [placed] = outer.findall("body")
    assert placed.get("name") == "object"
    assert {s.get("name") for s in outer.findall("site")} == {"bottom_site", "top_site", "horizontal_radius_site"}
    assert root.findall(".//freejoint") == []
    for geom in placed.iter("geom"):
        assert geom.get("name")
        assert geom.get("group") in ("0", "1")
        assert geom.get("mass") == "0"
        assert len(geom.get("size", "1 1").split()) in (2, 3)
    for region in [g for g in placed.iter("geom") if g.get("name", "").startswith("reg_")]:
        assert {"pos", "size", "rgba", "type"} <= set(region.keys())
        assert "quat" not in region.keys()  # noqa: SIM118  not a mapping


@pytest.mark.parametrize("build", EVERY)
def test_a_model_weighs_and_measures_what_the_asset_does(build: Callable[[], Asset], tmp_path: Path) -> None:
    asset = build()
    found = compiled(asset, tmp_path)
    assert found.body_mass.sum() == pytest.approx(asset.mass, rel=1e-6)
    half_height = np.array((0.0, 0.0, asset.bounds[:, 2].mean()))
    assert seen(found) == pytest.approx(asset.bounds - half_height, abs=1e-6)
    library = write_to(mjcf.write(asset), tmp_path / "library")
    other = mujoco.MjModel.from_xml_path(str(library / "model.xml"))
    assert found.body_inertia == pytest.approx(other.body_inertia, rel=1e-6)
    assert found.body_ipos[-1] + half_height == pytest.approx(other.body_ipos[-1], abs=1e-8)


def test_a_slice_stands_on_its_edge(tmp_path: Path) -> None:
    whole = slice_of_bread().root
    leaning = whole.inertial.replace(inertia=(*whole.inertial.inertia[:3], 1e-6, -2e-6, 1.5e-6))
    asset = slice_of_bread().replace(links=(whole.replace(inertial=leaning),))
    lying, stood = compiled(asset, tmp_path), compiled(asset, tmp_path, objects.UPRIGHT_FILE)
    x, y, z = asset.bounds[1] - asset.bounds[0]
    low, high = seen(stood)
    assert high - low == pytest.approx([z, x, y], abs=1e-6)
    assert low[2] == pytest.approx(-y / 2, abs=1e-6)
    assert (low + high)[:2] == pytest.approx([0, 0], abs=1e-6)
    [bounds] = parsed(asset, objects.UPRIGHT_FILE).findall(".//geom[@name='reg_bbox']")
    half_size = [float(v) for v in bounds.get("size", "").split()]
    assert half_size == pytest.approx([SLICE_SIZE[k] / 2 for k in (2, 0, 1)])
    assert stood.body_mass.sum() == lying.body_mass.sum()
    assert sorted(stood.body_inertia[-1]) == pytest.approx(sorted(lying.body_inertia[-1]))
    data = mujoco.MjData(stood)
    mujoco.mj_forward(stood, data)
    turn = objects.turn_of(asset)
    center = turn.apply(np.array([asset.root.inertial.center_of_mass]))[0]
    assert data.xipos[-1] == pytest.approx(center, abs=1e-6)
    spun = turn.rotation @ asset.root.inertial.tensor @ turn.rotation.T
    axes = data.ximat[-1].reshape(3, 3)
    assert axes @ np.diag(stood.body_inertia[-1]) @ axes.T == pytest.approx(spun, abs=1e-9)


SIDES = {"apple_00": Split.TRAIN, "apple_01": Split.TEST}
APPLE = [objects.Instance(id=name, category="apple", split=split) for name, split in SIDES.items()]
SHOE = objects.Instance(id="shoe_00", category="shoe", split=Split.TRAIN)


def tables(*instances: objects.Instance) -> dict[RobocasaRelease, dict[str, Any]]:
    return objects.category_tables(instances, registry.load().categories, "casa")


def test_attributes_of_a_generation() -> None:
    flags = {"graspable": True, "washable": True, "microwavable": False, "cookable": True, "freezable": False}
    for generation, more in zip(RobocasaRelease, ({}, {"fridgable": True, "dishwashable": False}), strict=True):
        row = tables(*APPLE)[generation]["apple"]
        assert {k: v for k, v in row.items() if isinstance(v, bool)} == flags | more
        assert row["types"] == ["fruit"]


def kind_of(*flags: str) -> Any:
    """In place of a runtime's class of a category with these attributes: keeps what it is given, looks for models."""

    def make(name: str, types: Any, **given: Any) -> Any:
        assert given.keys() == {"model_folders", "exclude", "scale", *flags}
        found = [p for folder in given["model_folders"] for p in Path("elsewhere", folder).glob("*/model.xml")]
        kept = [str(p) for p in found if p.parent.name not in given["exclude"]] * 2
        return SimpleNamespace(types=types, graspable=given["graspable"], mjcf_paths=kept)

    make.__signature__ = Signature([Parameter(flag, Parameter.KEYWORD_ONLY) for flag in flags])  # type: ignore[attr-defined]
    return make


@pytest.fixture
def exported(tmp_path: Path) -> Path:
    for instance in (*APPLE, SHOE):
        folder = tmp_path / objects.instance_folder(instance, "casa")
        folder.mkdir(parents=True)
        (folder / objects.FILE).touch()
    for generation, table in tables(*APPLE, SHOE).items():
        (tmp_path / objects.file_name(generation)).write_bytes(objects.json_bytes(table))
    return tmp_path


@pytest.mark.parametrize("generation", RobocasaRelease)
def test_every_registry_finds_its_instances(generation: RobocasaRelease, exported: Path) -> None:
    kind = kind_of(*(use.value for use in objects.ATTRIBUTES[generation]))
    categories: dict[str, Any] = {"apple": {"objaverse": "theirs"}}
    groups: dict[str, list[str]] = {"all": ["apple"], "fruit": ["apple"]}
    assert casa_objects.fill(kind, categories, groups, exported) == ("casa", "casa_test", "casa_train")
    apple = categories["apple"]
    assert apple["objaverse"] == "theirs"
    found = {name: [Path(p).parent.name for p in apple[name].mjcf_paths] for name in objects.registry_splits("casa")}
    # An object that is alone is there twice: RoboCasa's own splits take the first and the second half.
    halves = {"casa_train": ["apple_00"] * 2, "casa_test": ["apple_01"] * 2}
    assert found == {"casa": ["apple_00", "apple_01"], **halves}
    assert (apple["casa"].types, apple["casa"].graspable) == (("fruit",), True)
    assert groups == {"all": ["apple"], "fruit": ["apple"], "shoe": ["shoe"]}


@pytest.mark.parametrize("script", [casa_objects, casa_kitchens])
def test_what_is_copied_needs_nothing_of_ours(script: ModuleType) -> None:
    tree = ast.parse(Path(str(script.__file__)).read_text(encoding="utf-8"))
    froms = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    plain = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    assert {str(name).split(".")[0] for name in froms + plain} <= sys.stdlib_module_names


def test_things_that_do_not_fit_do_not_count() -> None:
    """A tool that is higher than a drawer keeps RoboCasa looking for ever."""
    ladle, mug = (registry.load().categories[name] for name in ("ladle", "mug"))
    assert "OpenDrawer" not in objects.missing_draws([(ladle, (0.3, 0.1, 0.08))])
    assert "OpenDrawer" in objects.missing_draws([(ladle, (0.1, 0.1, 0.3)), (mug, (0.1, 0.1, 0.08))])
