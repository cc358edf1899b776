"""Materials become portable, sheets get backs, and meshes with too many faces fewer."""

from __future__ import annotations

import io
from itertools import product

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from casa_assets import registry
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.texture import add_back_faces, painted, simplified, simplify, texture
from casa_assets.mesh.solid.deviation import measure_visibility
from casa_assets.mesh.surface import signed_volume
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.registry.category import MatterFill
from casa_assets.model.source import RawPart
from tests.support.hostile.untrusted_inputs import carton, kind_of, loose, without_side
from tests.support.mesh.meshes import box_mesh, lathe, some
from tests.support.mesh.meshes import texture as picture
from tests.support.mesh.raw_models import codes, draft, moved

BOX = box_mesh((0.1, 0.1, 0.1), (0, 0, 0))
PLAIN = Material(id="plain")
CHECKER = picture("checker", np.random.default_rng(0).integers(0, 255, (64, 32, 3), dtype=np.uint8))


def part(mesh: Mesh, material: Material = PLAIN) -> RawPart:
    return RawPart(name="p", mesh=mesh, material=material)


def done(*parts: RawPart, largest_px: int = 2048) -> Draft:
    return texture(Draft(parts=parts), largest_px, registry.load().substances["ceramic"])


def sampled(skin: Texture, uv: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Bilinear colour at (N, 2) uv, as a renderer reads it; origin at the lower left."""
    image = np.asarray(Image.open(io.BytesIO(skin.png))).astype(np.float64)
    at = (1 - uv[:, 1]) * skin.height_px - 0.5, uv[:, 0] * skin.width_px - 0.5
    return np.stack([map_coordinates(layer, at, order=1, mode="nearest") for layer in image.transpose(2, 0, 1)], -1)


def test_painted_colours_read_back_at_corners_centres_and_edges(subtests: pytest.Subtests) -> None:
    for alpha, count in product([255, None], [1, 2, 3, 7, 50, 501]):
        with subtests.test(count=count, alpha=alpha):
            draw = np.random.default_rng(0)  # so many loose triangles with random colours
            colors = draw.integers(0, 256, (3 * count, 4), dtype=np.uint8)
            if alpha is not None:
                colors[:, 3] = alpha
            mesh = Mesh(vertices=draw.random((3 * count, 3)), faces=np.arange(3 * count).reshape(-1, 3), colors=colors)
            out, material = painted(mesh, PLAIN)
            skin = some(material.base_color_texture)
            assert len(out.faces) == count
            assert (out.vertices[out.faces] == mesh.vertices[mesh.faces]).all()
            channels = 4 if alpha is None else 3
            corners = colors[mesh.faces][..., :channels].astype(float)
            for weights in (*np.eye(3), [1 / 3] * 3, *((1 - np.eye(3)) / 2)):
                at = np.einsum("k,nkd->nd", weights, some(out.uv)[out.faces])
                assert np.abs(sampled(skin, at) - np.einsum("k,nkd->nd", weights, corners)).max() <= 1.0


def test_one_colour_becomes_the_base_colour_in_linear_light() -> None:
    mesh = Mesh(vertices=BOX.vertices, faces=BOX.faces, colors=np.tile(np.uint8([188, 0, 255, 255]), (24, 1)))
    material = done(part(mesh, Material(id="m", base_color=(1, 1, 0.5, 1)))).parts[0].material
    assert material.base_color_texture is None
    assert material.base_color == pytest.approx((0.5029, 0, 0.5, 1), abs=1e-3)


@pytest.mark.parametrize(("alpha", "shown", "notes"), [(0.0, 1.0, ["MSH018"]), (0.3, 0.3, [])])
def test_an_invisible_material_is_made_opaque_and_glass_stays(alpha: float, shown: float, notes: list[str]) -> None:
    out = done(part(BOX, Material(id="m", base_color=(0.1, 0.2, 0.3, alpha))))
    assert out.parts[0].material.base_color == (0.1, 0.2, 0.3, shown)
    assert codes(out.notes) == notes


def test_pictures_are_scaled_down_to_the_limit() -> None:
    for largest, size in ((64, (32, 64)), (16, (8, 16)), (1, (1, 1))):
        out = done(part(BOX, Material(id="m", base_color_texture=CHECKER)), largest_px=largest).parts[0].material
        skin = some(out.base_color_texture)
        with Image.open(io.BytesIO(skin.png)) as image:
            assert image.size == size == (skin.width_px, skin.height_px)


def test_pictures_without_uv_are_left_out() -> None:
    bare = Mesh(vertices=BOX.vertices, faces=BOX.faces)
    out = done(part(bare, Material(id="m", base_color_texture=CHECKER, normal_texture=CHECKER)))
    assert out.parts[0].material.textures == ()
    assert codes(out.notes) == ["MSH017"]


def test_parts_of_one_look_become_one() -> None:
    red, blue = Material(id="a", base_color=(1, 0, 0, 1)), Material(id="b", base_color=(0, 0, 1, 1))
    boxes = [box_mesh((0.1, 0.1, 0.1), (x, 0, 0)) for x in (0.0, 1.0, 2.0)]
    out = done(part(boxes[0], red), part(boxes[1], blue), part(boxes[2], red.replace(id="c")))
    assert [len(p.mesh.faces) for p in out.parts] == [24, 12]
    merged = out.parts[0].mesh
    assert (merged.vertices[merged.faces] == np.concatenate([boxes[k].vertices[boxes[k].faces] for k in (0, 2)])).all()


ROW = kind_of(loose(carton()))
BOWL = lathe([(0.06, 0.05), (0.05, 0.02), (0.03, 0.0), (0.0, 0.0)], 32)


def after(mesh: Mesh, build: MatterFill) -> Draft:
    return add_back_faces(draft(mesh), ROW.replace(build=build), 0.5)


def behind(state: Draft) -> float:
    return float(measure_visibility(state.surface.vertices, state.surface.faces).behind.mean())


def test_a_bowl_without_a_thickness_is_seen_from_within() -> None:
    assert behind(draft(BOWL)) > 0.2
    made = after(BOWL, MatterFill.VESSEL)
    assert behind(made) < 0.01
    assert [n.code for n in made.notes] == ["MSH060"]
    mesh = made.parts[0].mesh
    assert len(mesh.faces) == 2 * len(BOWL.faces)
    assert mesh.uv is not None
    corners = mesh.vertices[mesh.faces]
    fronts = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", fronts, some(mesh.normals)[mesh.faces[:, 0]]) > 0).all()


def test_a_full_thing_without_a_side_stays_open_to_be_found() -> None:
    open_box = without_side(carton(), (0, 0, -1))
    assert after(open_box, MatterFill.FILLED).parts[0].mesh == open_box
    assert after(open_box, MatterFill.HOLLOW).parts[0].mesh != open_box


FINE = lathe([(0.05 * float(np.sin(t)), -0.05 * float(np.cos(t))) for t in np.linspace(0, np.pi, 60)], 120)


def rows(mesh: Mesh) -> set[bytes]:
    """Position and uv of every vertex, bit for bit."""
    columns = [mesh.vertices] + ([mesh.uv] if mesh.uv is not None else [])
    return {row.tobytes() for row in np.column_stack(columns)}


def test_the_limit_is_kept_and_vertices_are_those_of_the_input(subtests: pytest.Subtests) -> None:
    for with_uv, limit in product([True, False], [4000, 1500]):
        with subtests.test(limit=limit, with_uv=with_uv):
            mesh = FINE if with_uv else Mesh(vertices=FINE.vertices, faces=FINE.faces)
            out = simplify(draft(mesh), limit)
            few = out.parts[0].mesh
            assert 0.5 * limit < len(few.faces) <= 1.1 * limit
            assert (few.uv is not None) == with_uv
            assert rows(few) <= rows(mesh)
            assert codes(out.notes) == ["MSH015"]


def test_the_shape_and_the_seams_of_uv_stay() -> None:
    few = simplified(FINE, 1500)
    assert few.bounds == pytest.approx(FINE.bounds, abs=1e-3)
    volumes = [abs(signed_volume(m.vertices, m.faces.astype(np.int64))) for m in (few, FINE)]
    assert volumes[0] == pytest.approx(volumes[1], rel=0.02)
    away, _ = cKDTree(FINE.vertices).query(few.vertices[few.faces].mean(axis=1))
    assert away.max() < 0.01
    assert np.ptp(some(few.uv)[few.faces][:, :, 0], axis=1).max() < 0.5  # no face runs back over the whole picture
    assert simplified(FINE, 1500) == few


@pytest.mark.parametrize("pieces", [4, 16])
def test_no_face_shows_two_pieces_of_a_texture(pieces: int) -> None:
    # Each face is in the cell of a square of pieces that its middle lies in; with 16 the seams give way.
    middles = (FINE.vertices[FINE.faces].mean(axis=1)[:, :2] / 0.1 + 0.5).clip(0, 0.999)
    cell = np.repeat((middles * pieces).astype(int), 3, axis=0)
    places = FINE.vertices[FINE.faces.ravel()]
    uv = (cell + 0.5 + 0.4 * np.sin(40 * places[:, :2])) / pieces
    few = simplified(Mesh(vertices=places, faces=np.arange(len(places)).reshape(-1, 3), uv=uv), 1500)
    assert len(few.faces) <= 1500
    shown = np.floor(some(few.uv)[few.faces] * pieces)
    assert (shown == shown[:, :1]).all()


def test_parts_share_the_limit_and_small_ones_survive() -> None:
    crumb = moved(box_mesh((0.01, 0.01, 0.01), (0, 0, 0), shared=True), (0.2, 0, 0))
    out = simplify(draft(FINE, moved(FINE, (0.5, 0, 0), 0.5), crumb), 3000)
    counts = [len(p.mesh.faces) for p in out.parts]
    assert sum(counts) < 3600
    assert counts[2] == 12
    assert min(counts) > 0


def test_a_sheet_with_faces_in_both_directions_keeps_both_sides() -> None:
    both = Mesh(vertices=FINE.vertices, faces=np.concatenate([FINE.faces, FINE.faces[:, ::-1]]), uv=FINE.uv)
    few = simplified(both, 3000)
    assert 2000 < len(few.faces) <= 3000
    front, back = ({tuple(sorted(f)) for f in half.tolist()} for half in np.split(few.faces, 2))
    assert front == back
