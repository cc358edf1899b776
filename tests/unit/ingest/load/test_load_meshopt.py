"""glTF compressed by meshopt, as far as no decoder is needed: what is out of bounds, and what to do without one."""

from __future__ import annotations

import sys

import pytest

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes
from casa_assets.ingest.load.gltf_document import JsonObject, decompressed
from tests.mesh_files import MESHOPT_NAMES, load_bytes, packed_view, squeezed

STREAM = bytes.fromhex("a0" + "00" * 56)  # meshoptimizer's encoding of 100 vertices of 12 bytes, all zero


@pytest.mark.parametrize("name", MESHOPT_NAMES)
def test_without_a_decoder_the_message_says_what_to_do(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "meshoptimizer", None)
    made = squeezed([(STREAM, 12, "ATTRIBUTES", 100), (b"", 2, "TRIANGLES", 99)], name)
    with pytest.raises(Rejected, match=r"pip install meshoptimizer.*C\+\+ compiler.*gltf-transform copy") as caught:
        load_bytes("x.glb", made.glb())
    assert caught.value.code == rejection_codes.UNSUPPORTED_EXTENSION


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
        ({"mode": "TRIANGLES", "byteStride": 4}, rejection_codes.BAD_SCHEMA),
        ({"mode": "INDICES"}, rejection_codes.BAD_SCHEMA),
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
