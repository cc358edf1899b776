"""Objects as RoboCasa's loaders read them: structure, sizes, masses, what stands up, categories and splits."""

from __future__ import annotations

import ast
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
from casa_assets.formats import mjcf
from casa_assets.model.asset.asset import Asset, Joint, JointKind, Keyframe, Link, Split
from casa_assets.model.pose import Pose
from casa_assets.model.registry.contract import RobocasaRelease
from tests.support.asset.assets import ball, rigid_mug, textured_box, write_to
from tests.support.library.built_libraries import SLICE_SIZE, slice_of_bread

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


def box_of(root: etree._Element) -> np.ndarray:
    """Full size of `reg_bbox`."""
    [geom] = root.findall(".//geom[@name='reg_bbox']")
    return 2 * np.array([float(v) for v in geom.get("size", "").split()])


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
    assert seen(found)[0] == pytest.approx(asset.bounds[0] - half_height, abs=1e-6)
    assert seen(found)[1] == pytest.approx(asset.bounds[1] - half_height, abs=1e-6)
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
    assert box_of(parsed(asset, objects.UPRIGHT_FILE)) == pytest.approx([SLICE_SIZE[2], SLICE_SIZE[0], SLICE_SIZE[1]])
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


APPLE = [
    objects.Instance(id="apple_00", category="apple", split=Split.TRAIN),
    objects.Instance(id="apple_01", category="apple", split=Split.TEST),
]
SHOE = objects.Instance(id="shoe_00", category="shoe", split=Split.TRAIN)


def tables(*instances: objects.Instance) -> dict[RobocasaRelease, dict[str, Any]]:
    return objects.category_tables(instances, registry.load().categories, "casa")


def test_attributes_of_a_generation() -> None:
    first, second = (tables(*APPLE)[g]["apple"] for g in RobocasaRelease)
    flags = {"graspable": True, "washable": True, "microwavable": False, "cookable": True, "freezable": False}
    assert {k: v for k, v in first.items() if isinstance(v, bool)} == flags
    assert {k: v for k, v in second.items() if isinstance(v, bool)} == {
        **flags,
        "fridgable": True,
        "dishwashable": False,
    }
    assert first["types"] == second["types"] == ["fruit"]


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
    assert apple["casa"].types == ("fruit",)
    assert apple["casa"].graspable is True
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
