"""Looks: painted colours read back, merged parts, bounded pictures, alpha, and the shine where none is stated."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from casa_assets import registry
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.texture import painted, texture
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawPart
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.meshes import texture as picture
from tests.support.mesh.raw_models import codes

CERAMIC = registry.load().substances["ceramic"]
BOX = box_mesh((0.1, 0.1, 0.1), (0, 0, 0))
PLAIN = Material(id="plain")
CHECKER = picture("checker", np.random.default_rng(0).integers(0, 255, (64, 32, 3), dtype=np.uint8))


def colored(count: int, seed: int = 0, alpha: int | None = 255) -> Mesh:
    """So many loose triangles with random colours."""
    draw = np.random.default_rng(seed)
    colors = draw.integers(0, 256, (3 * count, 4), dtype=np.uint8)
    if alpha is not None:
        colors[:, 3] = alpha
    return Mesh(vertices=draw.random((3 * count, 3)), faces=np.arange(3 * count).reshape(-1, 3), colors=colors)


def part(mesh: Mesh, material: Material = PLAIN, name: str = "p") -> RawPart:
    return RawPart(name=name, mesh=mesh, material=material)


def done(*parts: RawPart, largest_px: int = 2048) -> Draft:
    return texture(Draft(parts=parts), largest_px, CERAMIC)


def sampled(skin: Texture, uv: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Bilinear colour at (N, 2) uv, as a renderer reads it; origin at the lower left."""
    image = np.asarray(Image.open(io.BytesIO(skin.png))).astype(np.float64)
    x, y = uv[:, 0] * skin.width_px - 0.5, (1 - uv[:, 1]) * skin.height_px - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - x0)[:, None], (y - y0)[:, None]
    rows, columns = np.clip([y0, y0 + 1], 0, skin.height_px - 1), np.clip([x0, x0 + 1], 0, skin.width_px - 1)
    top = image[rows[0], columns[0]] * (1 - fx) + image[rows[0], columns[1]] * fx
    low = image[rows[1], columns[0]] * (1 - fx) + image[rows[1], columns[1]] * fx
    return np.asarray(top * (1 - fy) + low * fy)


class TestPainted:
    def test_colours_read_back_at_corners_centres_and_edges(self, subtests: pytest.Subtests) -> None:
        for alpha in [255, None]:
            for count in [1, 2, 3, 7, 50, 501]:
                with subtests.test(count=count, alpha=alpha):
                    mesh = colored(count, alpha=alpha)
                    assert mesh.colors is not None
                    out, material = painted(mesh, PLAIN)
                    skin = material.base_color_texture
                    assert skin is not None
                    assert out.uv is not None
                    assert len(out.faces) == count
                    assert (out.vertices[out.faces] == mesh.vertices[mesh.faces]).all()
                    channels = 4 if alpha is None else 3
                    corners = mesh.colors[mesh.faces][..., :channels].astype(float)
                    for weights in (
                        [1, 0, 0],
                        [0, 1, 0],
                        [0, 0, 1],
                        [1 / 3] * 3,
                        [0.5, 0.5, 0],
                        [0, 0.5, 0.5],
                        [0.5, 0, 0.5],
                    ):
                        at = np.einsum("k,nkd->nd", weights, out.uv[out.faces])
                        wanted = np.einsum("k,nkd->nd", weights, corners)
                        assert np.abs(sampled(skin, at) - wanted).max() <= 1.0

    def test_one_colour_becomes_the_base_colour_in_linear_light(self) -> None:
        mesh = Mesh(vertices=BOX.vertices, faces=BOX.faces, colors=np.tile(np.uint8([188, 0, 255, 255]), (24, 1)))
        material = done(part(mesh, Material(id="m", base_color=(1, 1, 0.5, 1)))).parts[0].material
        assert material.base_color_texture is None
        assert material.base_color == pytest.approx((0.5029, 0, 0.5, 1), abs=1e-3)

    def test_a_picture_goes_before_vertex_colours(self) -> None:
        mesh = Mesh(vertices=BOX.vertices, faces=BOX.faces, uv=BOX.uv, colors=np.eye(24, 4).astype(np.uint8))
        out = done(part(mesh, Material(id="m", base_color_texture=CHECKER))).parts[0]
        assert out.material.base_color_texture == CHECKER
        assert out.mesh.uv is not None
        assert (out.mesh.uv == mesh.uv).all()


class TestAlpha:
    @pytest.mark.parametrize(("alpha", "shown", "notes"), [(0.0, 1.0, ["MSH018"]), (0.3, 0.3, [])])
    def test_an_invisible_material_is_made_opaque_and_glass_stays(
        self, alpha: float, shown: float, notes: list[str]
    ) -> None:
        out = done(part(BOX, Material(id="m", base_color=(0.1, 0.2, 0.3, alpha))))
        assert out.parts[0].material.base_color == (0.1, 0.2, 0.3, shown)
        assert codes(out.notes) == notes


class TestPictures:
    def test_are_scaled_down_to_the_limit(self) -> None:
        for largest, size in ((64, (32, 64)), (16, (8, 16)), (1, (1, 1))):
            skin = done(part(BOX, Material(id="m", base_color_texture=CHECKER)), largest_px=largest).parts[0].material
            assert skin.base_color_texture is not None
            with Image.open(io.BytesIO(skin.base_color_texture.png)) as image:
                assert image.size == size == (skin.base_color_texture.width_px, skin.base_color_texture.height_px)

    def test_without_uv_are_left_out(self) -> None:
        bare = Mesh(vertices=BOX.vertices, faces=BOX.faces)
        out = done(part(bare, Material(id="m", base_color_texture=CHECKER, normal_texture=CHECKER)))
        assert out.parts[0].material.textures == ()
        assert codes(out.notes) == ["MSH017"]


class TestMerging:
    def test_parts_of_one_look_become_one(self) -> None:
        red, blue = Material(id="a", base_color=(1, 0, 0, 1)), Material(id="b", base_color=(0, 0, 1, 1))
        boxes = [box_mesh((0.1, 0.1, 0.1), (x, 0, 0)) for x in (0.0, 1.0, 2.0)]
        out = done(part(boxes[0], red), part(boxes[1], blue), part(boxes[2], red.replace(id="c")))
        assert [len(p.mesh.faces) for p in out.parts] == [24, 12]
        merged = out.parts[0].mesh
        corners = np.concatenate([boxes[k].vertices[boxes[k].faces] for k in (0, 2)])
        assert (merged.vertices[merged.faces] == corners).all()


def test_the_defaults_of_gltf_yield_to_the_substance() -> None:
    unstated = done(part(BOX, Material(id="m", metallic=1.0, roughness=1.0))).parts[0].material
    assert (unstated.metallic, unstated.roughness) == (CERAMIC.metallic, CERAMIC.roughness)
    stated = done(part(BOX, Material(id="m", metallic=1.0, roughness=0.2))).parts[0].material
    assert (stated.metallic, stated.roughness) == (1.0, 0.2)
