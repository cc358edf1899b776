"""Objects of registry/objects/: each category builds, is as large and heavy as such things are; members differ."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from casa_assets.asset.family import Params, Supplies
from casa_assets.asset.kit.solids.solid import Solid
from casa_assets.asset.sampling import read_fixed, read_sample_rules
from casa_assets.cli.main import app
from casa_assets.core.numeric import rng_for
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.families.build import object_requests
from casa_assets.kitchenware.objects import FORMS
from casa_assets.kitchenware.objects.closed_surface import bent, lobed, smooth_profile, turned
from casa_assets.kitchenware.textures.objects.food import Skin, paint_skin
from casa_assets.mesh.surface import solid_moments
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.provenance import Labels
from casa_assets.model.registry.document import Document
from casa_assets.model.registry.rows import Finish
from casa_assets.registry.families import object_family, object_names
from casa_assets.textures.canvas import Canvas
from casa_assets.textures.run.recipes import every_recipe
from tests.support.asset.family_members import available, known

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


def is_closed(solid: Solid) -> bool:
    edges = np.sort(solid.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


def surfaces(asset: Asset) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for link in asset.links:
        for visual in link.visuals:
            yield visual.mesh.vertices, visual.mesh.faces


@pytest.mark.content("object", "{name}")
@pytest.mark.parametrize("name", object_names())
def test_members_are_as_large_and_heavy_as_such_things_are_and_differ(name: str) -> None:
    assert len({params_of(name, i).digest for i in range(DRAWN)}) == DRAWN
    limits, shapes = known().limits, set()
    for index in range(BUILT):
        asset = member(name, index)
        assert asset.base is Base.FREE
        assert asset.id.startswith(f"{name}_")
        assert asset.labels.category == name
        ranges = known().categories[name].usual(asset.labels.portion)
        low, high = ranges.mass_kg.low, ranges.mass_kg.high
        assert low / limits["mass_range_slack"] <= asset.mass <= high * limits["mass_range_slack"]
        longest = float(np.ptp(asset.bounds, axis=0).max())
        usual = ranges.longest_m
        assert usual.low / limits["size_slack"] <= longest <= usual.high * limits["size_slack"]
        assert abs(float(asset.bounds[0, 2])) < 1e-6
        assert sum(len(faces) for _, faces in surfaces(asset)) <= MAX_FACES
        assert all(solid_moments(points, faces)[0] > 0 for points, faces in surfaces(asset)), "closed and outward"
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


def test_a_turned_surface_is_closed_and_its_picture_runs_from_end_to_end() -> None:
    profile = smooth_profile([(0.0, 0.0), (0.03, 0.01), (0.04, 0.05), (0.0, 0.09)], 15)
    solid = turned(profile, 20)
    assert is_closed(solid)
    assert solid.volume > 0
    assert solid.picture_uv is not None
    assert solid.picture_uv.min() == 0.0
    assert solid.picture_uv.max() == 1.0
    height = solid.points[solid.faces][..., 2]
    assert np.corrcoef(height.ravel(), solid.picture_uv[..., 1].ravel())[0, 1] > 0.95


def test_a_bend_keeps_lengths_along_the_axis_and_what_lies_beyond_goes_on_straight() -> None:
    line = np.column_stack([np.zeros(50), np.zeros(50), np.linspace(0.0, 0.3, 50)])
    turned_line = bent(line, 1.0, 0.0, (0.0, 0.2))
    steps = np.linalg.norm(np.diff(turned_line, axis=0), axis=1)
    assert np.allclose(steps, steps[0], rtol=1e-3)
    last = turned_line[-1] - turned_line[-2]
    assert np.arctan2(last[0], last[2]) == pytest.approx(1.0, abs=1e-6)


def test_furrows_are_as_many_and_as_deep_as_is_said() -> None:
    angle = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(720)])
    radius = np.linalg.norm(lobed(ring, 4, 0.2, 1.0, 0.0)[:, :2], axis=1)
    assert radius.min() == pytest.approx(0.8, abs=1e-3)
    assert radius.max() == pytest.approx(1.0, abs=1e-3)
    assert ((radius < np.roll(radius, 1)) & (radius < np.roll(radius, -1))).sum() == 4


def test_a_skin_has_its_colors_at_their_ends_and_is_the_same_for_the_same_generator() -> None:
    skin = Skin(colors=("#ff0000", "#00ff00"), mottle=0.0)
    canvas = Canvas((64, 64), (0.1, 0.1))
    layers = paint_skin(skin, canvas, np.random.default_rng(1))
    assert layers.albedo[0].mean(axis=0)[1] > 0.9, "the upper end is green"
    assert layers.albedo[-1].mean(axis=0)[0] > 0.9, "the lower end is red"
    assert np.array_equal(layers.albedo, paint_skin(skin, canvas, np.random.default_rng(1)).albedo)
    with pytest.raises(ValueError, match="a place for each of 2 colours"):
        Skin(colors=("#ff0000", "#00ff00"), at=(0.0, 0.5, 1.0))


def test_the_command_builds_and_lists(tmp_path: Path) -> None:
    run = CliRunner()
    listed = run.invoke(app, ["objects", "list", "--json"])
    assert listed.exit_code == 0
    assert '"apple"' in listed.output
    built = run.invoke(app, ["objects", "build", "apple", "--count", "1", "--library", str(tmp_path), "--jobs", "1"])
    assert built.exit_code == 0, built.output
    assert len(list(tmp_path.glob("apple/apple_*/model.xml"))) == 1
    assert run.invoke(app, ["objects", "build"]).exit_code == 2
