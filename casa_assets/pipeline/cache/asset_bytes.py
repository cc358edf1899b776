"""Asset <-> bytes: JSON and plain arrays in one .npz. Reading it runs no code, whoever wrote it."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from casa_assets.model.asset.asset import Asset

# Stand in the JSON for an array (its kind, where it begins, its shape) and for a picture (the digest of its bytes); no
# field of a record is called so.
ARRAY, PICTURE = "$array", "$picture"
ARRAY_TYPES = ("float64", "int32", "uint8")
TREE = "tree"
DIGEST_BYTES = 32
LEAVES = frozenset((str, int, float, bool))
# Errors that a file which `pack` did not write may raise, even where its digest is right.
READ_ERRORS = (
    ValueError,
    TypeError,
    LookupError,
    OSError,
    EOFError,
    ArithmeticError,
    RecursionError,
    zipfile.BadZipFile,
)

Tree = dict[str, Any]


def pack(tree: Tree, key: str) -> tuple[bytes, dict[str, bytes]]:
    """A record's `model_dump()` as bytes, its digest in front; the same tree is the same bytes.

    Args:
        tree: dicts, lists, numbers, text, arrays of float64, int32 and uint8, and pictures as bytes.
        key: under which it is kept; `unpack` asks for it again.
    Returns:
        The bytes, and the pictures by their sha256: many assets share them.
    """
    found: dict[str, list[npt.NDArray[Any]]] = {kind: [] for kind in ARRAY_TYPES}
    starts, pictures = dict.fromkeys(ARRAY_TYPES, 0), {}

    def plain(value: Any) -> Any:
        if value is None or type(value) in LEAVES:  # nearly all that there is
            return value
        if isinstance(value, np.ndarray):
            kind = value.dtype.name
            place = [kind, starts[kind], list(value.shape)]
            found[kind].append(value.ravel())
            starts[kind] += value.size
            return {ARRAY: place}
        if isinstance(value, bytes):
            name = hashlib.sha256(value).hexdigest()
            pictures[name] = value
            return {PICTURE: name}
        if isinstance(value, dict):
            return {name: plain(item) for name, item in value.items()}
        if isinstance(value, list | tuple):
            return [plain(item) for item in value]
        return value

    text = json.dumps({"key": key, "record": plain(tree)}, sort_keys=True, separators=(",", ":"), allow_nan=False)
    flat = {kind: np.concatenate([np.empty(0, kind), *parts]) for kind, parts in found.items()}
    out = io.BytesIO()
    np.savez(out, allow_pickle=False, **{TREE: np.frombuffer(text.encode(), np.uint8)}, **flat)
    data = out.getvalue()
    return hashlib.sha256(data).digest() + data, pictures


def unpack(data: bytes, key: str, picture: Callable[[str], bytes]) -> Asset:
    """The asset that was packed under a key.

    Args:
        data: what `pack` gave. picture: the bytes of a picture by their sha256.
    Raises:
        One of READ_ERRORS: these are not those bytes, or not of that key, or no asset.
    """
    body = data[DIGEST_BYTES:]
    if hashlib.sha256(body).digest() != data[:DIGEST_BYTES]:
        raise ValueError("the bytes are not those that were written")
    with np.load(io.BytesIO(body), allow_pickle=False) as arrays:
        values = {kind: arrays[kind] for kind in ARRAY_TYPES}
        json_text = arrays[TREE].tobytes()

    def whole(node: Tree) -> Any:
        if ARRAY in node:
            kind, start, shape = node[ARRAY]
            return values[kind][start : start + int(np.prod(shape))].reshape(shape)
        return picture(node[PICTURE]) if PICTURE in node else node

    tree = json.loads(json_text, object_hook=whole)
    if tree["key"] != key:
        raise ValueError("the bytes are those of another key")
    return Asset.model_validate(tree["record"])
