"""Objects of registry/objects/: as large and heavy as such things are, cut into portions, made once as a library."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from typer.testing import CliRunner

from casa_assets.addons.robocasa.run import ExportResult, export
from casa_assets.asset.family import Params, Supplies
from casa_assets.asset.sampling import read_fixed, read_sample_rules
from casa_assets.cli.main import app
from casa_assets.core.numeric import rng_for
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.families.build import (
    PROPORTION_STEP,
    FamilyResult,
    build_all,
    build_asset,
    family_of,
    object_requests,
    shape_digest,
)
from casa_assets.families.build import params_of as params_asked_for
from casa_assets.formats.mjcf import document
from casa_assets.kitchenware.objects import FORMS
from casa_assets.kitchenware.objects.closed_surface import across, along, cut, sector, shell, smooth_profile, turned
from casa_assets.kitchenware.objects.produce import Face, Produce, rest_tilt
from casa_assets.library.entry_files import read_asset
from casa_assets.library.library import Library
from casa_assets.library.search import entries_that
from casa_assets.mesh.surface import is_closed, solid_moments
from casa_assets.model.asset.asset import Asset, Base, Labels
from casa_assets.model.asset.material import Material
from casa_assets.model.registry.category import Portion
from casa_assets.model.registry.document import Document
from casa_assets.model.registry.rows import Finish
from casa_assets.registry.families import object_family, object_names
from casa_assets.show.reports.library_page import write as write_page
from casa_assets.textures.run.recipes import every_recipe
from tests.support.asset.family_members import available, known
from tests.support.library.libraries import tree

pytestmark = pytest.mark.content("code", "families", keep=0)

# Members of a category that are built, and that have to differ; most faces of one.
BUILT, DRAWN, MAX_FACES = 2, 16, 9_000


def params_of(name: str, index: int) -> Params:
    drawn: Params = object_family(name).draw(rng_for(0, f"objects/{name}/{index}"), available())
    return drawn


def supplies(name: str, params: Params) -> Supplies:
    """Finishes without pictures: those of skins have the substance of their recipe."""
    category, finishes = known().categories[name], {}
    for finish in (*known().materials, *params.finishes):
        row = known().materials.get(finish) or every_recipe()[finish]
        substance = known().substances[row.substance]
        finishes[finish] = Finish(id=finish, material=Material(id=finish), substance=substance)
    labels = Labels(category=category.id, classes=known().classes_of(category), qcode=category.qcode)
    return Supplies(finishes, labels, known().densities)


def member(name: str, index: int) -> Asset:
    params = params_of(name, index)
    asset: Asset = object_family(name).build(params, supplies(name, params))
    return asset


@pytest.mark.content("object", "{name}")
@pytest.mark.parametrize("name", object_names())
def test_members_are_as_large_and_heavy_as_such_things_are_and_differ(name: str) -> None:
    assert len({params_of(name, i).digest for i in range(DRAWN)}) == DRAWN
    shapes = set()
    heavier, longer = (known().limits[key] for key in ("mass_range_slack", "size_slack"))
    for index in range(BUILT):
        asset = member(name, index)
        assert asset.base is Base.FREE
        assert asset.id.startswith(f"{name}_")
        assert asset.labels.category == name
        ranges = known().categories[name].usual(asset.labels.portion)
        longest = float(np.ptp(asset.bounds, axis=0).max())
        assert ranges.mass_kg.low / heavier <= asset.mass <= ranges.mass_kg.high * heavier
        assert ranges.longest_m.low / longer <= longest <= ranges.longest_m.high * longer
        assert abs(float(asset.bounds[0, 2])) < 1e-6
        meshes = [visual.mesh for link in asset.links for visual in link.visuals]
        assert sum(len(mesh.faces) for mesh in meshes) <= MAX_FACES
        assert all(solid_moments(mesh.vertices, mesh.faces)[0] > 0 for mesh in meshes), "closed and outward"
        assert 1 <= sum(len(link.colliders) for link in asset.links) <= 24
        shapes.add(tuple(np.round(np.ptp(asset.bounds, axis=0), 4)))
    assert len(shapes) == BUILT
    assert member(name, 0) == member(name, 0)


def test_every_form_is_used_and_draws_are_numbered_by_category() -> None:
    assert {object_family(name).form for name in object_names()} == set(FORMS)
    requests = [(r.family, r.index) for r in object_requests(["apple", "pear"], 2, 0)]
    assert requests == [("apple", 0), ("apple", 1), ("pear", 0), ("pear", 1)]
    with pytest.raises(UnknownId, match="apple"):
        object_requests(["aple"], 1, 0)


class Thing(Params):
    """Numbers of a made-up form."""

    line: tuple[tuple[float, float], ...]
    size: float = 1.0


def test_one_of_picks_a_constant_and_fixed_values_are_in_every_member() -> None:
    document = Document(file="objects/x.yaml", value={}, lines={})
    lines = [[[0.0, 1.0], [1.0, 2.0]], [[0.0, 3.0]]]
    draw = read_sample_rules(Thing, {"line": {"one_of": lines}}, document, ("x",), {"size": 2.0})
    found = [draw(np.random.default_rng(seed), available()) for seed in range(12)]
    assert {thing.line for thing in found} == {((0.0, 1.0), (1.0, 2.0)), ((0.0, 3.0),)}
    assert {thing.size for thing in found} == {2.0}
    with pytest.raises(RegistryError, match="sise"):
        read_fixed(Thing, {"sise": 2.0}, document, ("x", "fixed"))
    with pytest.raises(RegistryError):
        read_fixed(Thing, {"size": "large"}, document, ("x", "fixed"))


def test_the_command_builds_and_lists(tmp_path: Path) -> None:
    run = CliRunner()
    assert '"apple"' in run.invoke(app, ["objects", "list", "--json"]).output
    built = run.invoke(app, ["objects", "build", "apple", "--count", "1", "--library", str(tmp_path), "--jobs", "1"])
    assert built.exit_code == 0, built.output
    assert len(list(tmp_path.glob("apple/apple_*/model.xml"))) == 1
    assert run.invoke(app, ["objects", "build"]).exit_code == 2


# What is cut ----------------------------------------------------------------------------------------------------------

HEIGHT = 0.09
PROFILE = smooth_profile([(0.0, 0.0), (0.03, 0.01), (0.04, 0.05), (0.0, HEIGHT)], 17)
BODY = turned(PROFILE, 24)
MIDDLE = np.array([0.0, 0.0, HEIGHT / 2])


def test_halves_and_wedges_have_their_share_of_the_volume_and_stay_closed() -> None:
    for planes, share in (([along(0.4, MIDDLE)], 0.5), (sector(0.9, MIDDLE), 0.9 / (2 * np.pi))):
        kept, faces = cut(BODY, planes)
        assert kept.volume / BODY.volume == pytest.approx(share, rel=0.02)
        assert len(faces) == len(planes)
        assert all(is_closed(solid.faces) and solid.volume > 0 for solid in (kept, *faces))


def test_a_face_lies_on_its_plane_within_the_outline_and_its_picture_fills_the_disc() -> None:
    kept, (face,) = cut(BODY, [across(0.04, below=True)])
    assert kept.points[:, 2].max() == pytest.approx(0.04)
    assert np.abs(face.points[:, 2] - 0.04).max() < 0.001
    assert np.hypot(*face.points[:, :2].T).max() < np.hypot(*kept.points[:, :2].T).max()
    assert face.picture_uv is not None
    off = np.hypot(*(face.picture_uv.reshape(-1, 2) - 0.5).T)
    assert off.max() == pytest.approx(0.49, abs=1e-3)
    assert off.min() == pytest.approx(0.0, abs=1e-6)


def test_a_hollow_leaves_a_ring_and_a_cut_that_misses_is_told() -> None:
    hollow = replace(BODY, points=MIDDLE + 0.8 * (BODY.points - MIDDLE))
    kept, (face,) = cut(BODY, [along(0.0, MIDDLE)], hollow)
    assert kept.volume == pytest.approx(0.5 * (BODY.volume - hollow.volume), rel=0.02)
    assert np.linalg.norm(face.points - MIDDLE, axis=1).min() > 0.015
    lining = shell(replace(BODY, points=MIDDLE + 0.81 * (BODY.points - MIDDLE)), hollow, [along(0.0, MIDDLE)])
    assert is_closed(lining.faces)
    with pytest.raises(ValueError, match="leave nothing"):
        cut(BODY, [across(-0.01, below=True)])
    with pytest.raises(ValueError, match="does not meet"):
        cut(BODY, [across(0.2, below=True)])


def test_portions_lie_on_the_ground_and_say_what_they_are_and_a_whole_thing_does_not() -> None:
    pear = object_family("pear")
    params = pear.draw(rng_for(0, "x"), available()).replace(bend=0.0, portion=None)
    whole = pear.build(params, supplies("pear", params))
    assert "portion" not in document.label_texts(whole)
    assert "portion" not in whole.labels.to_json()
    for portion, crosswise in [*((p, False) for p in Portion), (Portion.HALF, True)]:
        for face in list(Face):
            part = params.replace(section="section_pear", portion=portion, crosswise=crosswise, face=face)
            asset = pear.build(part, supplies("pear", part))
            assert asset.mass < whole.mass
            assert asset.labels.portion is portion
            assert asset.labels.to_json().count("portion") == 1
            assert document.label_texts(asset)["portion"] == portion.value
            assert abs(float(asset.bounds[0, 2])) < 1e-6
    with pytest.raises(ValidationError, match="a section is expected"):
        Produce(profile=((0, 0), (1, 0.3), (1, 0.7), (0, 1)), length=0.1, width=0.1, skin="x", portion=Portion.HALF)


@pytest.mark.content("object", "watermelon", keep=1)
@pytest.mark.content("object", "mango")
def test_a_stalk_grows_out_of_a_fruit_that_lies() -> None:
    for name in ("watermelon", "mango"):
        points = {v.label: v.mesh.vertices for v in member(name, 0).root.visuals}
        gaps = np.linalg.norm(points["stem"][:, None] - points["body"], axis=2)
        assert gaps.min() < 0.005, name
        assert points["body"][:, 2].min() < 0.001, "the fruit itself lies on the ground"


@pytest.mark.content("object", "cereal", keep=1)
def test_an_open_carton_is_as_full_as_a_closed_one() -> None:
    carton, params = object_family("cereal"), params_of("cereal", 0)
    closed, opened = (carton.build(p, supplies("cereal", p)) for p in (params.replace(opens=o) for o in (False, True)))
    assert opened.mass == pytest.approx(closed.mass, rel=0.05)


def test_a_half_that_lies_on_its_side_rolls_to_where_its_mass_is_lowest() -> None:
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 41)
    ball = turned(0.04 * np.column_stack([np.cos(tilt) * (np.abs(tilt) < 1.57), np.sin(tilt)]), 60)
    half, _ = cut(ball, [across(0.0, below=True)])
    level = replace(half, points=half.points[:, [2, 0, 1]])
    # A hemisphere comes to rest with its face up; its face looked to +x before.
    assert np.degrees(rest_tilt(level)) == pytest.approx(-90.0, abs=8.0)
    assert rest_tilt(half.rotated("x", np.pi)) == pytest.approx(0.0, abs=1e-6), "on its face it is at rest"


def test_a_slice_on_a_slant_is_longer_and_as_thick() -> None:
    for slant in (0.0, 0.6):
        at = 0.05 * np.cos(slant)
        planes = [across(at + 0.003, below=True, slant=slant), across(at - 0.003, below=False, slant=slant)]
        kept, _ = cut(BODY, planes)
        normal = np.array([np.sin(slant), 0.0, np.cos(slant)])
        assert np.ptp(kept.points @ normal) == pytest.approx(0.006)
        assert is_closed(kept.faces)


# A library of objects -------------------------------------------------------------------------------------------------

NAMES, COUNT = ("candy", "saucepan_lid"), 2


def build(library: Path) -> list[FamilyResult]:
    return list(build_all(object_requests(NAMES, COUNT, 0), library, jobs=1, drawn=False))


def entries(library: Path) -> dict[str, bytes | None]:
    """All files of a library but those of its cache."""
    return {name: data for name, data in tree(library).items() if not name.startswith(".casa/")}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("objects") / "lib"
    results = build(folder)
    assert [r.problems for r in results if not r.passed] == []
    assert not any(r.is_kept for r in results)
    return folder


def test_every_member_is_an_entry_and_a_row_and_pages_and_exports_read_it(library: Path, tmp_path: Path) -> None:
    folders = list(Library(library).accepted())
    assert Counter(f.parent.name for f in folders) == dict.fromkeys(NAMES, COUNT)
    rows = list(entries_that(Library(library), ()))
    assert sorted(row.id for row in rows) == sorted(f.name for f in folders)
    assert {row.producer for row in rows} == {"family"}
    assert {row.split for row in rows} <= {"train", "test"}
    assert json.loads((library / "library.json").read_text())["report"]["subject"]
    write_page(library, tmp_path / "report.html")
    assert NAMES[0] in (tmp_path / "report.html").read_text(encoding="utf-8")
    done = [one for one in export(library, tmp_path / "out") if isinstance(one, ExportResult)]
    assert all(one.model for one in done)
    assert {one.id: one.split for one in done} == {f.name: str(read_asset(f).labels.split) for f in folders}


def test_what_is_missing_is_made_again_to_the_same_bytes(library: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(library, tmp_path / "lib")
    before = entries(copy)
    lost, broken = list(Library(copy).accepted())[:2]
    shutil.rmtree(lost)
    (broken / "model.xml").unlink()
    results = build(copy)
    assert {Path(r.folder) for r in results if not r.is_kept} == {lost, broken}
    assert all(r.passed for r in results)
    assert entries(copy) == before
    assert all(r.is_kept for r in build(copy))


def shaped(name: str, index: int, cache: Path, **changes: Any) -> tuple[Asset, str]:
    """An asset, and the digest of its shape."""
    request = object_requests([name], index + 1, 0)[index]
    params = params_asked_for(request).replace(**changes)
    asset = build_asset(family_of(request), params, cache)
    return asset, shape_digest(asset, params)


def test_shapes_differ_by_proportions_and_design_alone(tmp_path: Path) -> None:
    """Colours and seeds have no part in them."""
    (_, can), (_, apple) = shaped("can", 0, tmp_path), shaped("apple", 0, tmp_path)
    assert shaped("can", 0, tmp_path, label=None, body="foil_gold")[1] == can
    assert shaped("apple", 0, tmp_path, seed=7_777)[1] == apple
    height = params_asked_for(object_requests(["can"], 1, 0)[0]).model_dump()["height"]
    assert shaped("can", 0, tmp_path, height=float(height * np.exp(2 * PROPORTION_STEP)))[1] != can
    assert shaped("can", 0, tmp_path, grooves=5)[1] != can


def test_one_shape_is_never_on_both_sides_of_a_split(tmp_path: Path) -> None:
    sides: dict[str, set[str]] = {}
    for index in range(12):
        asset, digest = shaped("candy", index, tmp_path)
        sides.setdefault(digest, set()).add(str(asset.labels.split))
    assert len(sides) < 12  # some are alike
    assert all(len(found) == 1 for found in sides.values())


def test_a_mug_is_taken_by_its_handle_and_fingers_close_on_things_within_their_opening(tmp_path: Path) -> None:
    mug, _ = shaped("mug", 0, tmp_path)
    handle = next(site for site in mug.sites if site.name == "grasp_handle")
    assert (handle.size or (1.0,))[0] < 0.03
    assert handle.pose.position[0] > 0.35 * float(np.ptp(mug.bounds, axis=0)[0])
    for name in ("apple", "can", "bowl"):
        asset, _ = shaped(name, 1, tmp_path)
        sites = [site for site in asset.sites if site.name.startswith("grasp_")]
        assert sites, name
        assert all(site.size and 0 < site.size[0] <= 0.08 for site in sites)
        places = np.array([site.pose.position for site in sites])
        assert (np.abs(places - asset.bounds.mean(axis=0)) <= np.ptp(asset.bounds, axis=0) / 2 + 0.002).all()
