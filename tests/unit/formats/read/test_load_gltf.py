"""GLB and glTF, plain or packed by Draco, meshopt, KTX 2 and WebP: what is read rightly, and what is refused."""

from __future__ import annotations

import io
import math
import struct
import sys

import DracoPy
import numpy as np
import pytest
from PIL import Image

from casa_assets.errors import Rejected
from casa_assets.formats.read.gltf import Mapping2D
from casa_assets.formats.read.gltf_document import JsonObject, decompressed
from casa_assets.model import rejection_codes as codes
from tests.support.mesh.mesh_files import (
    ETC1S,
    MESHOPT_NAMES,
    QUARTERS,
    UASTC,
    Gltf,
    codes_of,
    glb_bytes,
    load_bytes,
    packed_view,
    png,
    refusal,
    squeezed,
    texel,
)
from tests.support.mesh.meshes import box_mesh

RED, GREEN, BLUE = (255, 0, 0), (0, 255, 0), (0, 0, 255)


def test_uv_are_turned_to_the_lower_left_and_moved_as_the_picture_says() -> None:
    made = Gltf()
    made.paint(png(QUARTERS))
    model = load_bytes("x.glb", made.glb())
    # glTF (0,0) is the upper left texel, (1,0) the upper right, (0,1) the lower left
    assert [texel(model, 0, i) for i in range(3)] == [RED, GREEN, BLUE]
    moved = {"KHR_texture_transform": {"offset": [0.5, 0.0], "scale": [0.5, 0.5]}}
    picture = {"index": 0, "extensions": moved}
    made.document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": picture}}]
    made.document["extensionsRequired"] = ["KHR_texture_transform"]
    assert texel(load_bytes("x.glb", made.glb()), 0, 0) == GREEN
    turned = Mapping2D(rotation=math.pi / 2).apply(np.array([[0.25, 0.5]]))
    assert np.allclose(turned, [[0.5, 1.25]])
    # the second set of coordinates, where the picture asks for it
    made.attributes["TEXCOORD_1"] = made.add(np.array([[1, 0], [1, 0], [1, 0]], dtype="<f4"), "VEC2")
    made.document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}}]
    assert texel(load_bytes("x.glb", made.glb()), 0, 0) == GREEN


def test_mirrored_node_turns_the_faces_and_the_normals_follow() -> None:
    made = Gltf()
    made.attributes["NORMAL"] = made.add(np.array([[0, 0, 1]] * 3, dtype="<f4"), "VEC3")
    made.node["scale"] = [-2, 1, 1]
    mesh = load_bytes("x.glb", made.glb()).parts[0].mesh
    a, b, c = mesh.vertices[mesh.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0
    assert np.allclose(np.array(mesh.normals), [0, 0, 1])


def test_strips_and_fans() -> None:
    for mode, faces in [(5, [[0, 1, 2], [2, 1, 3]]), (6, [[0, 1, 2], [0, 2, 3]])]:
        made = Gltf([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [0, 1, 2, 3])
        made.primitive["mode"] = mode
        assert load_bytes("x.glb", made.glb()).parts[0].mesh.faces.tolist() == faces


def test_quantised_and_sparse_accessors() -> None:
    made = Gltf()
    at = made.add(np.array([[0, 0, 0, 0], [127, 0, 0, 0], [0, -127, 0, 0]], dtype="i1"), "VEC3", normalized=True)
    made.accessors[at]["count"] = 3
    made.views[int(str(made.accessors[at]["bufferView"]))]["byteStride"] = 4
    made.attributes["POSITION"] = at
    indices, values = made.view(struct.pack("<H", 0)), made.view(struct.pack("<3b", 0, 0, 127))
    made.accessors[at]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": indices, "componentType": 5123},
        "values": {"bufferView": values},
    }
    assert np.allclose(load_bytes("x.glb", made.glb()).parts[0].mesh.vertices, [[0, 0, 1], [1, 0, 0], [0, -1, 0]])


def test_vertex_colours_become_srgb() -> None:
    made = Gltf()
    made.attributes["COLOR_0"] = made.add(np.array([[0.2158605, 0, 1]] * 3, dtype="<f4"), "VEC3")
    colors = load_bytes("x.glb", made.glb()).parts[0].mesh.colors
    assert np.array(colors)[0].tolist() == [128, 0, 255, 255]


def test_specular_glossiness_and_unlit_and_emissive_pictures_give_a_base_colour() -> None:
    old = {"diffuseTexture": {"index": 0}, "diffuseFactor": [1, 0.5, 1, 1], "glossinessFactor": 0.25}
    made = Gltf()
    made.paint(png(QUARTERS))
    made.document["materials"] = [{"extensions": {"KHR_materials_pbrSpecularGlossiness": old}}]
    made.document["extensionsRequired"] = ["KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit"]
    material = load_bytes("x.glb", made.glb()).parts[0].material
    assert material.base_color == (1.0, 0.5, 1.0, 1.0)
    assert (material.metallic, material.roughness) == (0.0, 0.75)
    assert material.base_color_texture is not None
    black = {"baseColorFactor": [0, 0, 0, 1]}
    glow = {"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": black}
    made.document["materials"] = [glow]
    model = load_bytes("x.glb", made.glb())
    assert model.parts[0].material.base_color_texture is not None
    assert codes.EMISSIVE_AS_BASE in codes_of(model)


def test_alpha_follows_the_mode() -> None:
    for mode, color_type in {"OPAQUE": 2, "BLEND": 6, "MASK": 6}.items():  # of PNG: 2 RGB, 6 RGBA
        made = Gltf()
        made.paint(png(np.full((2, 2, 4), 100, dtype=np.uint8)), alphaMode=mode)
        texture = load_bytes("x.glb", made.glb()).parts[0].material.base_color_texture
        assert texture is not None
        assert texture.png[25] == color_type


def test_rest_pose_of_a_rigged_mesh_comes_from_its_joints() -> None:
    made = Gltf()
    made.attributes["JOINTS_0"] = made.add(np.zeros((3, 4), dtype="u1"), "VEC4")
    made.attributes["WEIGHTS_0"] = made.add(np.array([[1, 0, 0, 0]] * 3, dtype="<f4"), "VEC4")
    made.document["nodes"] = [{"mesh": 0, "skin": 0, "translation": [99, 0, 0]}, {"scale": [2, 2, 2]}]
    made.document["scenes"] = [{"nodes": [0, 1]}]
    made.document["skins"] = [{"joints": [1]}]
    model = load_bytes("x.glb", made.glb())
    assert model.parts[0].mesh.vertices[1].tolist() == [2, 0, 0]
    assert codes_of(model) == {codes.FEATURE_IGNORED}


def test_broken_containers_are_refused() -> None:
    for cut, code in [
        (lambda d: d[:8], codes.TRUNCATED),
        (lambda d: d[:12], codes.TRUNCATED),
        (lambda d: d[: len(d) // 2], codes.TRUNCATED),
        (lambda d: d[:-10], codes.TRUNCATED),
        (lambda d: b"glTX" + d[4:], codes.BAD_MAGIC),
        (lambda d: d[:4] + struct.pack("<I", 1) + d[8:], codes.UNSUPPORTED_VERSION),
        (lambda d: d[:8] + struct.pack("<I", 200) + d[12:], codes.LENGTH_MISMATCH),
        (lambda d: d[:8] + struct.pack("<I", 2**32 - 1) + d[12:], codes.LENGTH_MISMATCH),
        (lambda d: d[:12] + struct.pack("<I", 2**32 - 1) + d[16:], codes.LENGTH_MISMATCH),
        (lambda d: d.replace(b'"asset"', b'"asset '), codes.BAD_JSON),
        (lambda d: b"\x89PNG\r\n\x1a\n" + d, codes.WRONG_TYPE),
        (lambda d: b"<!DOCTYPE html><html>" + d, codes.WRONG_TYPE),
        (lambda d: b"\x1f\x8b" + d, codes.WRONG_TYPE),
        (lambda d: b"version https://git-lfs.github.com/spec/v1\n", codes.WRONG_TYPE),
        (lambda d: b"", codes.EMPTY_FILE),
    ]:
        assert refusal("x.glb", cut(Gltf().glb())) == code


def test_claims_beyond_the_bytes_are_refused_before_allocation() -> None:
    made = Gltf()
    made.accessors[0]["count"] = 10_000
    assert refusal("x.glb", made.glb()) == codes.OUT_OF_BOUNDS
    del made.accessors[0]["bufferView"]
    made.accessors[0]["count"] = 2_000_000_000
    assert refusal("x.glb", made.glb()) == codes.TOO_LARGE
    made = Gltf()
    made.binary = b"\0" * 2**20
    assert refusal("x.gltf", made.text("data:;base64,AAAA")) == codes.LENGTH_MISMATCH
    assert refusal("x.glb", Gltf(indices=[0, 1, 9]).glb()) == codes.OUT_OF_BOUNDS
    made = Gltf(indices=[0, 1, 2] * 20_000)
    made.document["nodes"] = [{"mesh": 0} for _ in range(6)]
    made.document["scenes"] = [{"nodes": list(range(6))}]
    assert refusal("x.glb", made.glb()) == codes.TOO_LARGE


def test_bad_scene_graphs_are_refused() -> None:
    for nodes, code in [
        ([{"children": [0], "mesh": 0}], codes.BAD_SCENE_GRAPH),
        ([{"children": [i + 1, i + 1]} for i in range(30)] + [{"mesh": 0}], codes.BAD_SCENE_GRAPH),
        ([{"children": [7]}], codes.OUT_OF_BOUNDS),
        ([{"mesh": 7}], codes.OUT_OF_BOUNDS),
        ([{"mesh": "0"}], codes.BAD_SCHEMA),
        ([{"mesh": 0, "translation": [float("nan"), 0, 0]}], codes.NON_FINITE),
        ([{"mesh": 0, "translation": "up"}], codes.BAD_SCHEMA),
        (["node"], codes.BAD_SCHEMA),
    ]:
        made = Gltf()
        made.document["nodes"] = nodes
        assert refusal("x.glb", made.glb()) == code


def test_what_cannot_be_read_costs_the_input_or_the_picture_and_nothing_to_show_the_input() -> None:
    made = Gltf()
    made.document["extensionsRequired"] = ["X_y"]
    assert refusal("x.glb", made.glb()) == codes.UNSUPPORTED_EXTENSION
    for picture in (b"no picture at all", png(QUARTERS)[:-30], png(np.zeros((600, 600), dtype=np.uint8))):
        made = Gltf()
        made.paint(picture)
        model = load_bytes("x.glb", made.glb())
        assert model.parts[0].material.textures == ()
        assert codes_of(model) in ({codes.IMAGE_UNREADABLE}, {codes.IMAGE_REFUSED})

    made = Gltf()
    made.primitive["mode"] = 0
    assert refusal("x.glb", made.glb()) == codes.NO_FACES
    made.document["meshes"] = []
    made.document["nodes"] = [{}]
    assert refusal("x.glb", made.glb()) == codes.NO_GEOMETRY
    assert refusal("x.glb", glb_bytes({"asset": {"version": "2.0"}})) == codes.NO_GEOMETRY


DRACO = "KHR_draco_mesh_compression"
STREAM = bytes.fromhex("a0" + "00" * 56)  # meshoptimizer's encoding of 100 vertices of 12 bytes, all zero
BOX = box_mesh((0.08, 0.1, 0.06), (0.0, 0.05, 0.0), shared=True)


def packed_by_draco(**changed: object) -> Gltf:
    """A box with texture coordinates; `changed` overrides what the extension says."""
    uv = np.linspace(0.0, 1.0, 2 * len(BOX.vertices)).reshape(-1, 2)
    how = {"tex_coord": uv, "quantization_bits": 16, "preserve_order": True, "compression_level": 7}
    data = DracoPy.encode(BOX.vertices, BOX.faces, **how)
    made = Gltf([(0.0, 0.0, 0.0)] * len(BOX.vertices), [0] * BOX.faces.size)
    made.attributes["TEXCOORD_0"] = made.add(uv.astype("<f4"), "VEC2")
    for accessor in made.accessors:
        del accessor["bufferView"]
    attributes = {one["unique_id"]: one["attribute_type"] for one in DracoPy.decode(data).attributes}
    ids = {{0: "POSITION", 3: "TEXCOORD_0"}[kind]: number for number, kind in attributes.items()}
    made.primitive["extensions"] = {DRACO: {"bufferView": made.view(data), "attributes": ids, **changed}}
    made.document["extensionsRequired"] = [DRACO]
    return made


def test_draco_comes_out_as_it_went_in() -> None:
    mesh = load_bytes("a.glb", packed_by_draco().glb()).parts[0].mesh
    size = float(np.ptp(BOX.vertices, axis=0).max())
    corners, wanted = (np.sort(m.vertices[m.faces].reshape(-1, 3), axis=0) for m in (mesh, BOX))
    assert corners == pytest.approx(wanted, rel=0.0, abs=1e-4 * size)
    assert mesh.uv is not None
    assert refusal("a.glb", packed_by_draco(bufferView=0).glb()) == codes.TRUNCATED
    assert refusal("a.glb", packed_by_draco(attributes={"POSITION": 77}).glb()) == codes.BAD_SCHEMA
    made = packed_by_draco()
    made.accessors[0]["count"] = 3
    assert refusal("a.glb", made.glb()) == codes.LENGTH_MISMATCH
    made.accessors[1]["count"] = 10**9
    assert refusal("a.glb", made.glb()) == codes.TOO_LARGE
    made = packed_by_draco()
    points = {"bufferView": made.view(DracoPy.encode(BOX.vertices)), "attributes": {"POSITION": 0}}
    made.primitive["extensions"] = {DRACO: points}
    assert refusal("a.glb", made.glb()) in (codes.NO_FACES, codes.TRUNCATED)


def test_pictures_in_ktx2_and_webp_are_read_and_webp_before_its_stand_in() -> None:
    for picture in (UASTC, ETC1S):
        made = Gltf()
        made.paint(picture)
        made.document["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
        made.document["extensionsRequired"] = ["KHR_texture_basisu"]
        model = load_bytes("a.glb", made.glb())
        found = np.array([texel(model, 0, vertex)[:3] for vertex in range(3)])
        assert np.abs(found - [RED, GREEN, BLUE]).max() < 8
    out = io.BytesIO()
    Image.fromarray(QUARTERS).save(out, "WEBP", lossless=True)
    made = Gltf()
    made.paint(png(np.zeros((2, 2, 3), np.uint8)))
    made.document["images"] = [*made.document["images"], {"bufferView": made.view(out.getvalue())}]  # type: ignore[misc]
    made.document["textures"] = [{"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}]
    model = load_bytes("a.glb", made.glb())
    assert [texel(model, 0, vertex) for vertex in range(3)] == [RED, GREEN, BLUE]


def test_a_ktx2_picture_that_lies_is_left_out() -> None:
    for broken in (
        UASTC[:20],
        UASTC[:100],
        UASTC[:20] + struct.pack("<II", 2**31, 2**31) + UASTC[28:],
        UASTC[:12] + struct.pack("<I", 37) + UASTC[16:],
    ):
        made = Gltf()
        made.paint(broken)
        model = load_bytes("a.glb", made.glb())
        assert model.parts[0].material.base_color_texture is None
        assert codes_of(model) & {codes.IMAGE_UNREADABLE, codes.IMAGE_REFUSED}


@pytest.mark.parametrize("name", MESHOPT_NAMES)
def test_without_a_decoder_the_message_says_what_to_do(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "meshoptimizer", None)
    made = squeezed([(STREAM, 12, "ATTRIBUTES", 100), (b"", 2, "TRIANGLES", 99)], name)
    with pytest.raises(Rejected, match=r"pip install meshoptimizer.*C\+\+ compiler.*gltf-transform copy") as caught:
        load_bytes("x.glb", made.glb())
    assert caught.value.code == codes.UNSUPPORTED_EXTENSION


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"mode": "PICTURES"}, codes.UNSUPPORTED_EXTENSION),
        ({"filter": "COLOR"}, codes.UNSUPPORTED_EXTENSION),
        ({"filter": "OCTAHEDRAL"}, codes.BAD_SCHEMA),
        ({"byteStride": 6}, codes.BAD_SCHEMA),
        ({"byteStride": 0}, codes.BAD_SCHEMA),
        ({"byteStride": 260}, codes.BAD_SCHEMA),
        ({"count": 10**9}, codes.TOO_LARGE),
        ({"mode": "TRIANGLES", "byteStride": 4}, codes.BAD_SCHEMA),
        ({"mode": "INDICES"}, codes.BAD_SCHEMA),
    ],
)
def test_what_is_out_of_bounds_is_rejected_with_or_without_a_decoder(
    changes: dict[str, object], code: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "meshoptimizer", None)
    with pytest.raises(Rejected) as caught:
        decompressed(JsonObject(packed_view(STREAM, 12, "ATTRIBUTES", 100) | changes, "x"), STREAM, 10**8)
    assert caught.value.code == code
    assert "pip install" not in str(caught.value)
