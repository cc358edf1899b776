"""glTF compressed by meshoptimizer: read to the bit, and refused before it does harm."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.errors import Rejected
from casa_assets.formats.read.gltf_document import JsonObject, decompressed
from casa_assets.model import rejection_codes
from tests.support.mesh.mesh_files import MESHOPT_NAMES, load_bytes, packed_view, squeezed
from tests.support.mesh.raw_models import MUG, turned
from tests.support.program.environments import packages_of

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module", autouse=True)
def codec() -> Iterator[Any]:
    """The module meshoptimizer, which encodes what our reader decodes by it."""
    packages = str(packages_of("meshopt"))
    sys.path.append(packages)
    yield importlib.import_module("meshoptimizer")
    sys.path.remove(packages)


def mug_columns(codec: Any) -> list[tuple[bytes, int, str, int]]:
    points, faces = mug()
    return [
        (codec.encode_vertex_buffer(points, len(points), 12), 12, "ATTRIBUTES", len(points)),
        (codec.encode_index_buffer(faces.ravel(), faces.size, len(points)), 2, "TRIANGLES", faces.size),
    ]


def mug() -> tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]:
    mesh = turned(MUG)
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)


@pytest.mark.parametrize("name", MESHOPT_NAMES)
def test_comes_out_as_it_went_in(codec: Any, name: str) -> None:
    points, faces = mug()
    mesh = load_bytes("x.glb", squeezed(mug_columns(codec), name).glb()).parts[0].mesh
    assert np.array_equal(mesh.vertices.astype(np.float32), points)
    # The codec may begin a triangle at another of its corners.
    found, wanted = ({tuple(np.roll(f, -int(np.argmin(f)))) for f in rows.tolist()} for rows in (mesh.faces, faces))
    assert found == wanted


@pytest.mark.parametrize("wide", [2, 4])
def test_sequences_of_indices(codec: Any, wide: int) -> None:
    indices = np.array([0, 5, 3, 3, 2, 9, 1], dtype=np.uint32)
    data = codec.encode_index_sequence(indices, len(indices), 10)
    out = decompressed(JsonObject(packed_view(data, wide, "INDICES", len(indices)), "x"), data, 10**6)
    assert np.frombuffer(out, f"<u{wide}").tolist() == indices.tolist()


def filtered(codec: Any, values: npt.NDArray[Any], name: str) -> bytes:
    data = codec.encode_vertex_buffer(values.view(np.float32), 3, 4)
    return decompressed(JsonObject(packed_view(data, 4, "ATTRIBUTES", 3, filter=name), "x"), data, 10**6)


def test_exponents_become_floats_and_octahedral_normals_have_length_one(codec: Any) -> None:
    # Ref: EXT_meshopt_compression, filter EXPONENTIAL: 8 bits of exponent over 24 bits of mantissa.
    exponents = np.array([[0x00000003], [0x01FFFFFF], [0xFF000005]], dtype=np.uint32)
    assert np.frombuffer(filtered(codec, exponents, "EXPONENTIAL"), "<f4").tolist() == [3.0, -2.0, 2.5]
    normals = np.array([[0, 0, 127, 0], [127, 0, 127, 0], [0, -127, 127, 0]], dtype=np.int8)
    got = np.frombuffer(filtered(codec, normals, "OCTAHEDRAL"), "i1").reshape(3, 4)[:, :3]
    assert got.tolist() == [[0, 0, 127], [127, 0, 0], [0, -127, 0]]


def test_streams_of_something_else_and_broken_ones(codec: Any) -> None:
    zeros = bytes(codec.encode_vertex_buffer(np.zeros((100, 3), dtype=np.float32), 100, 12))
    view = packed_view(zeros, 12, "ATTRIBUTES", 100)
    for changes in ({"count": 200}, {"mode": "TRIANGLES", "byteStride": 4, "count": 99}):
        with pytest.raises(Rejected) as caught:
            decompressed(JsonObject(view | changes, "x"), zeros, 10**8)
        assert caught.value.code == rejection_codes.TRUNCATED
    draw = np.random.default_rng(0)
    told = JsonObject(view, "x")
    for cut in (0, 1, len(zeros) // 2, len(zeros) - 1):
        with pytest.raises(Rejected):
            decompressed(told, zeros[:cut], 10**8)
    for _ in range(300):  # whatever comes out, it has the size that was claimed, or is refused
        corrupted = bytearray(zeros)
        corrupted[int(draw.integers(len(zeros)))] = int(draw.integers(256))
        with suppress(Rejected):
            assert len(decompressed(told, bytes(corrupted), 10**8)) == 1200


def test_a_view_that_claims_more_than_is_packed(codec: Any) -> None:
    made = squeezed(mug_columns(codec), MESHOPT_NAMES[0])
    made.views[0]["byteLength"] = 10**6
    with pytest.raises(Rejected) as caught:
        load_bytes("x.glb", made.glb())
    assert caught.value.code == rejection_codes.LENGTH_MISMATCH
