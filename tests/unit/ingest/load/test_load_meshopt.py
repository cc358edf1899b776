"""glTF compressed by meshoptimizer: read to the bit, and refused before it does harm."""

from __future__ import annotations

from contextlib import suppress

import meshoptimizer
import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes
from casa_assets.ingest.load.gltf.meshopt import decompressed
from casa_assets.ingest.load.gltf.tree import JsonObject
from tests.mesh_files import Gltf, load_bytes
from tests.raw_models import MUG, turned

NAMES = ["EXT_meshopt_compression", "KHR_meshopt_compression"]


def packed(data: bytes, stride: int, mode: str, count: int, **extra: object) -> dict[str, object]:
    """An extension object, of which `data` is left to be placed."""
    return {
        "buffer": 0,
        "byteOffset": 0,
        "byteLength": len(data),
        "byteStride": stride,
        "mode": mode,
        "count": count,
    } | extra


def squeezed(points: npt.NDArray[np.float32], faces: npt.NDArray[np.uint32], name: str) -> Gltf:
    """A mesh whose positions and indices are compressed, with a fallback buffer that holds nothing."""
    made = Gltf([(0.0, 0.0, 0.0)] * len(points), [0] * faces.size)
    columns = (
        (meshoptimizer.encode_vertex_buffer(points, len(points), 12), 12, "ATTRIBUTES", len(points)),
        (meshoptimizer.encode_index_buffer(faces.ravel(), faces.size, len(points)), 2, "TRIANGLES", faces.size),
    )
    made.binary = b""
    for view, (data, stride, mode, count) in zip(list(made.views), columns, strict=True):
        start = len(made.binary)
        made.binary += data + b"\0" * (-len(data) % 4)
        view |= {"buffer": 1, "byteOffset": 0, "byteLength": count * stride}
        view["extensions"] = {name: packed(data, stride, mode, count) | {"byteOffset": start}}
    made.document["extensionsRequired"] = [name]
    made.document["buffers"] = [
        {"byteLength": len(made.binary)},
        {"byteLength": 10**9, "extensions": {name: {"fallback": True}}},
    ]
    return made


@pytest.mark.parametrize("name", NAMES)
def test_comes_out_as_it_went_in(name: str) -> None:
    mug = turned(MUG)
    points, faces = mug.vertices.astype(np.float32), mug.faces.astype(np.uint32)
    mesh = load_bytes("x.glb", squeezed(points, faces, name).glb()).parts[0].mesh
    assert np.array_equal(mesh.vertices.astype(np.float32), points)
    # The codec may begin a triangle at another of its corners.
    assert {tuple(np.roll(f, -int(np.argmin(f)))) for f in mesh.faces.tolist()} == {
        tuple(np.roll(f, -int(np.argmin(f)))) for f in faces.tolist()
    }


@pytest.mark.parametrize("wide", [2, 4])
def test_sequences_of_indices(wide: int) -> None:
    indices = np.array([0, 5, 3, 3, 2, 9, 1], dtype=np.uint32)
    data = meshoptimizer.encode_index_sequence(indices, len(indices), 10)
    out = decompressed(JsonObject(packed(data, wide, "INDICES", len(indices)), "x"), data, 10**6)
    assert np.frombuffer(out, f"<u{wide}").tolist() == indices.tolist()


def test_exponents_become_floats() -> None:
    # Ref: EXT_meshopt_compression, filter EXPONENTIAL: 8 bits of exponent over 24 bits of mantissa.
    values = np.array([[0x00000003], [0x01FFFFFF], [0xFF000005]], dtype=np.uint32)
    data = meshoptimizer.encode_vertex_buffer(values.view(np.float32), 3, 4)
    out = decompressed(JsonObject(packed(data, 4, "ATTRIBUTES", 3, filter="EXPONENTIAL"), "x"), data, 10**6)
    assert np.frombuffer(out, "<f4").tolist() == [3.0, -2.0, 2.5]


def test_octahedral_normals_have_length_one() -> None:
    values = np.array([[0, 0, 127, 0], [127, 0, 127, 0], [0, -127, 127, 0]], dtype=np.int8)
    data = meshoptimizer.encode_vertex_buffer(values.view(np.float32), 3, 4)
    out = decompressed(JsonObject(packed(data, 4, "ATTRIBUTES", 3, filter="OCTAHEDRAL"), "x"), data, 10**6)
    got = np.frombuffer(out, "i1").reshape(3, 4)[:, :3]
    assert got.tolist() == [[0, 0, 127], [127, 0, 0], [0, -127, 0]]


class TestRefused:
    def data(self) -> bytes:
        return bytes(meshoptimizer.encode_vertex_buffer(np.zeros((100, 3), dtype=np.float32), 100, 12))

    @pytest.mark.parametrize(
        ("changes", "code"),
        [
            ({"mode": "PICTURES"}, rejection_codes.UNSUPPORTED_EXTENSION),
            ({"filter": "COLOR"}, rejection_codes.UNSUPPORTED_EXTENSION),
            ({"filter": "OCTAHEDRAL"}, rejection_codes.BAD_SCHEMA),
            ({"byteStride": 6}, rejection_codes.BAD_SCHEMA),
            ({"byteStride": 0}, rejection_codes.BAD_SCHEMA),
            ({"byteStride": 260}, rejection_codes.BAD_SCHEMA),
            ({"count": 10**9}, rejection_codes.TOO_LARGE),
            ({"count": 200}, rejection_codes.TRUNCATED),
            ({"mode": "TRIANGLES", "byteStride": 4}, rejection_codes.BAD_SCHEMA),
            ({"mode": "TRIANGLES", "byteStride": 4, "count": 99}, rejection_codes.TRUNCATED),
            ({"mode": "INDICES"}, rejection_codes.BAD_SCHEMA),
        ],
    )
    def test_what_is_out_of_bounds(self, changes: dict[str, object], code: str) -> None:
        data = self.data()
        with pytest.raises(Rejected) as caught:
            decompressed(JsonObject(packed(data, 12, "ATTRIBUTES", 100) | changes, "x"), data, 10**8)
        assert caught.value.code == code

    def test_broken_streams(self) -> None:
        data = self.data()
        draw = np.random.default_rng(0)
        for cut in (0, 1, len(data) // 2, len(data) - 1):
            with pytest.raises(Rejected):
                decompressed(JsonObject(packed(data, 12, "ATTRIBUTES", 100), "x"), data[:cut], 10**8)
        for _ in range(300):  # whatever comes out, it has the size that was claimed, or is refused
            corrupted = bytearray(data)
            corrupted[int(draw.integers(len(data)))] = int(draw.integers(256))
            with suppress(Rejected):
                assert (
                    len(decompressed(JsonObject(packed(data, 12, "ATTRIBUTES", 100), "x"), bytes(corrupted), 10**8))
                    == 1200
                )

    def test_a_view_that_claims_more_than_is_packed(self) -> None:
        mug = turned(MUG)
        made = squeezed(mug.vertices.astype(np.float32), mug.faces.astype(np.uint32), NAMES[0])
        made.views[0]["byteLength"] = 10**6
        with pytest.raises(Rejected) as caught:
            load_bytes("x.glb", made.glb())
        assert caught.value.code == rejection_codes.LENGTH_MISMATCH
