"""Built assets, their light forms and USD layers, kept on disk as plain arrays and JSON by what they are made from."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt
from pydantic.main import IncEx

from casa_assets.asset.assemble import Family
from casa_assets.asset.family import Params
from casa_assets.asset.lightweight import lighten
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.core.system import max_cache_bytes
from casa_assets.families.build import asset_key, build_asset
from casa_assets.formats.usd import document
from casa_assets.model.asset.asset import Asset

# Asset <-> bytes: JSON and plain arrays in one .npz. Reading it runs no code, whoever wrote it.

# In the JSON: an array (kind, begin, shape) and a picture (digest of its bytes); no field of a record is called so.
ARRAY, PICTURE = "$array", "$picture"
ARRAY_TYPES = ("float64", "int32", "uint8")
TREE = "tree"
DIGEST_BYTES = 32
LEAVES = frozenset((str, int, float, bool))
# Errors that a file which `pack` did not write may raise, even where its digest is right.
READ_ERRORS = (ValueError, TypeError, LookupError, OSError, EOFError, ArithmeticError, RecursionError, BadZipFile)

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

    picture: the bytes of a picture by their sha256. Raises one of READ_ERRORS: the data are not what `pack` gave, or
    not of that key, or no asset.
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


# <cache>/assets/{built,pictures,layers}/ by `families.build.asset_key` or content: a change of one family leaves others

FOLDER = "assets"
# Part of a cache's bound for assets and light forms (about 40 kB each), and as much for pictures and for layers.
SHARE = 0.25
# Fields of an asset that its light form does not depend on.
UNSEEN: Mapping[str, IncEx | bool] = {"materials": True, "links": {"__all__": {"visuals": {"__all__": {"mesh"}}}}}


class AssetStore:
    """Assets by family and numbers; any number of processes may read and write the folder at once.

    What is missing, damaged or incomplete there is built again. cache: folder of pictures of finishes, too.
    """

    def __init__(self, cache: Path) -> None:
        self._cache = cache
        stores = (Store(cache / FOLDER / name, is_optional=True) for name in ("built", "pictures", "layers"))
        self._assets, self._pictures, self._layers = stores
        self._seen: dict[str, bytes] = {}
        self._wrote = False

    def built(self, found: Family[Any], params: Params) -> Asset:
        """The asset of a family's numbers, kept or built now. Raises as the family's `build` does."""
        return self._kept(_key("built", asset_key(found, params)), lambda: build_asset(found, params, self._cache))

    def lightened(self, asset: Asset) -> Asset:
        """The light form of an asset, kept or made now: `lighten`, by what it depends on and not by the id."""
        bare, _ = pack(asset.model_dump(exclude=UNSEEN), "")
        return self._kept(_key("light", hashlib.sha256(bare).hexdigest(), key_of(lighten)), lambda: lighten(asset))

    def layer_text(self, asset: Asset, textures: str) -> str:
        """The USD layer of an asset, kept or written now: `document.layer_text`."""
        content, _ = pack(asset.model_dump(), "")
        key = _key("layer", hashlib.sha256(content).hexdigest(), textures, key_of(document.layer_text))
        data = self._layers.get(key)
        if data is None:
            data = document.layer_text(asset, textures).encode("utf-8")
            self._layers.put(key, data)
            self._wrote = True
        return data.decode("utf-8")

    def tidy(self) -> None:
        """Remove what was used longest ago where the store has grown too large; free if nothing was written."""
        if not self._wrote:
            return
        self._wrote = False
        for store in (self._assets, self._pictures, self._layers):
            store.trim(int(SHARE * max_cache_bytes()))

    def _kept(self, key: str, make: Callable[[], Asset]) -> Asset:
        data = self._assets.get(key)
        if data is not None:
            try:
                return unpack(data, key, self._picture)
            except READ_ERRORS:
                pass  # made again below, and written over
        asset = make()
        data, pictures = pack(asset.model_dump(), key)
        fresh = [name for name in pictures if name not in self._seen]
        self._seen.update(pictures)
        for name in fresh:
            if self._pictures.get(name) != pictures[name]:
                self._pictures.put(name, pictures[name])
        self._assets.put(key, data)
        self._wrote = True
        return asset

    def _picture(self, name: str) -> bytes:
        """Bytes by their sha256. Raises ValueError where they are not there, or others."""
        if name not in self._seen:
            data = self._pictures.get(name)
            if data is None or hashlib.sha256(data).hexdigest() != name:
                raise ValueError(f"picture {name} is missing or damaged")
            self._seen[name] = data
        return self._seen[name]


def _key(*words: str) -> str:
    return digest_of(*words, key_of(pack, unpack))
