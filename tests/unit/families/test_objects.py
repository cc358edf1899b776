"""Objects of registry/objects/: each category builds, is as large and heavy as such things are; members differ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from casa_assets.asset.family import Params, Supplies
from casa_assets.asset.sampling import read_fixed, read_sample_rules
from casa_assets.asset.solid import Solid
from casa_assets.cli.main import app
from casa_assets.core.numeric import rng_for
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.families.build import object_requests
from casa_assets.kitchenware.objects import FORMS
from casa_assets.mesh.surface import solid_moments
from casa_assets.model.asset.asset import Asset, Base, Labels
from casa_assets.model.asset.material import Material
from casa_assets.model.registry.document import Document
from casa_assets.model.registry.rows import Finish
from casa_assets.registry.families import object_family, object_names
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
