"""glTF compressed by Draco or meshopt, pictures in KTX 2 and WebP: read as what they were packed from, or refused."""

from __future__ import annotations

import io
import struct
import sys

import DracoPy
import numpy as np
import pytest
from PIL import Image

from casa_assets.errors import Rejected
from casa_assets.formats.read.gltf_document import JsonObject, decompressed
from casa_assets.model import rejection_codes as codes
from tests.support.mesh.mesh_files import (
    ETC1S,
    MESHOPT_NAMES,
    QUARTERS,
    UASTC,
    Gltf,
    codes_of,
    load_bytes,
    packed_view,
    png,
    refusal,
    squeezed,
    texel,
)
from tests.support.mesh.meshes import box_mesh

DRACO = "KHR_draco_mesh_compression"
STREAM = bytes.fromhex("a0" + "00" * 56)  # meshoptimizer's encoding of 100 vertices of 12 bytes, all zero
BOX = box_mesh((0.08, 0.1, 0.06), (0.0, 0.05, 0.0), shared=True)


def packed_by_draco(**changed: object) -> Gltf:
    """A box with texture coordinates; `changed` overrides what the extension says."""
    uv = np.linspace(0.0, 1.0, 2 * len(BOX.vertices)).reshape(-1, 2)
    data = DracoPy.encode(
        BOX.vertices, BOX.faces, tex_coord=uv, quantization_bits=16, preserve_order=True, compression_level=7
    )
    made = Gltf([(0.0, 0.0, 0.0)] * len(BOX.vertices), [0] * BOX.faces.size)
    made.attributes["TEXCOORD_0"] = made.add(uv.astype("<f4"), "VEC2")
    for accessor in made.accessors:
        del accessor["bufferView"]
    attributes = {one["unique_id"]: one["attribute_type"] for one in DracoPy.decode(data).attributes}
    names = {0: "POSITION", 3: "TEXCOORD_0"}
    ids = {names[kind]: number for number, kind in attributes.items()}
    extension = {"bufferView": made.view(data), "attributes": ids, **changed}
    made.primitive["extensions"] = {DRACO: extension}
    made.document["extensionsRequired"] = [DRACO]
    return made


def test_draco_comes_out_as_it_went_in() -> None:
    mesh = load_bytes("a.glb", packed_by_draco().glb()).parts[0].mesh
    size = float(np.ptp(BOX.vertices, axis=0).max())
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    wanted = BOX.vertices[BOX.faces].reshape(-1, 3)
    assert len(corners) == len(wanted)
    assert np.abs(np.sort(corners, axis=0) - np.sort(wanted, axis=0)).max() < 1e-4 * size
    assert mesh.uv is not None


def test_draco_that_is_broken_is_refused() -> None:
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


@pytest.mark.parametrize("picture", [UASTC, ETC1S])
def test_a_ktx2_picture_is_read(picture: bytes) -> None:
    made = Gltf()
    made.paint(picture)
    made.document["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}]
    made.document["extensionsRequired"] = ["KHR_texture_basisu"]
    model = load_bytes("a.glb", made.glb())
    found = np.array([texel(model, 0, vertex)[:3] for vertex in range(3)])
    # In glTF the first row of a picture is the upper one: (0, 0) red, (1, 0) green, (0, 1) blue.
    assert np.abs(found - [[255, 0, 0], [0, 255, 0], [0, 0, 255]]).max() < 8


def test_a_webp_picture_is_read_before_its_stand_in() -> None:
    out = io.BytesIO()
    Image.fromarray(QUARTERS).save(out, "WEBP", lossless=True)
    made = Gltf()
    made.paint(png(np.zeros((2, 2, 3), np.uint8)))
    made.document["images"] = [*made.document["images"], {"bufferView": made.view(out.getvalue())}]  # type: ignore[misc]
    made.document["textures"] = [{"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}]
    model = load_bytes("a.glb", made.glb())
    assert [texel(model, 0, vertex) for vertex in range(3)] == [(255, 0, 0), (0, 255, 0), (0, 0, 255)]


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
