"""What is kept of a built asset is the asset, and nothing else that lies there is taken for it."""

from __future__ import annotations

import hashlib
import io
import os
import zlib
from collections.abc import Callable
from copy import copy
from functools import wraps
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from casa_assets.asset.assemble import Family
from casa_assets.asset.family import Params, Supplies
from casa_assets.asset.lightweight import lighten
from casa_assets.families import asset_store
from casa_assets.families.asset_store import ARRAY_TYPES, TREE, AssetStore, pack, unpack
from casa_assets.formats.usd import document
from casa_assets.model.asset.asset import Asset
from casa_assets.registry.families import family, family_names
from tests.support.asset.assets import textured_box
from tests.support.asset.family_members import preset

pytestmark = pytest.mark.content("code", "cache", keep=0)

KETTLE = family("kettle")
NUMBERS = KETTLE.presets["jug_steel"]


def counted(build: Callable[[Params, Supplies], Asset] = KETTLE.build) -> tuple[Family[Any], Mock]:
    """A family, and what counts how often it has built."""
    made, count = copy(KETTLE), Mock(side_effect=build)
    object.__setattr__(made, "build", count)  # of a frozen record
    return made, count


def entries(cache: Path, kind: str = "built") -> list[Path]:
    return sorted(p for p in cache.glob(f"assets/{kind}/*/*"))


@pytest.mark.parametrize("name", family_names())
def test_an_asset_of_each_family_reads_back_the_same(name: str) -> None:
    asset = preset(name, next(iter(family(name).presets)))
    data, pictures = pack(asset.model_dump(), "key")
    again = unpack(data, "key", pictures.__getitem__)
    assert (again.id, again.digest) == (asset.id, asset.digest)


def test_what_was_built_once_is_not_built_again(tmp_path: Path) -> None:
    kettle, count = counted()
    first, second = (AssetStore(tmp_path).built(kettle, NUMBERS) for _ in range(2))
    assert count.call_count == 1
    assert (second.id, second.digest) == (first.id, first.digest)


def one_bit(data: bytes, other: bytes) -> bytes:
    changed = bytearray(zlib.decompress(data))
    changed[len(changed) // 2] ^= 1
    return zlib.compress(bytes(changed))


DAMAGES: dict[str, Callable[[bytes, bytes], bytes]] = {
    "torn": lambda data, other: data[:-9],
    "empty": lambda data, other: b"",
    "one bit": one_bit,
    "swapped": lambda data, other: other,
    "no archive": lambda data, other: zlib.compress(hashlib.sha256(b"x").digest() + b"x"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_entry_is_made_anew(tmp_path: Path, damage: str) -> None:
    kettle, count = counted()
    first = AssetStore(tmp_path).built(kettle, NUMBERS)
    (path,) = entries(tmp_path)
    AssetStore(tmp_path).built(kettle, NUMBERS.replace(height=NUMBERS.model_dump()["height"] + 0.01))
    (beside,) = (p for p in entries(tmp_path) if p != path)
    good = path.read_bytes()
    path.write_bytes(DAMAGES[damage](good, beside.read_bytes()))
    assert path.read_bytes() != good
    assert AssetStore(tmp_path).built(kettle, NUMBERS).digest == first.digest
    assert count.call_count == 3
    assert path.read_bytes() == good


@pytest.mark.parametrize(
    "damage", [Path.unlink, lambda path: path.write_bytes(zlib.compress(b"\x89PNG\r\n\x1a\nanother"))]
)
def test_a_missing_or_wrong_picture_is_put_back(tmp_path: Path, damage: Callable[[Path], None]) -> None:
    box, count = counted(lambda params, supplies: textured_box())
    first = AssetStore(tmp_path).built(box, NUMBERS)
    (path, *_) = entries(tmp_path, "pictures")
    good = path.read_bytes()
    damage(path)
    assert AssetStore(tmp_path).built(box, NUMBERS).digest == first.digest
    assert count.call_count == 2
    assert path.read_bytes() == good


class Planted:
    """Runs a command where it is unpickled."""

    def __init__(self, sign: Path) -> None:
        self.sign = sign

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.sign),)


def test_no_code_of_an_entry_is_run(tmp_path: Path) -> None:
    (kettle, count), sign = counted(), tmp_path / "sign"
    first = AssetStore(tmp_path / "cache").built(kettle, NUMBERS)
    (path,) = entries(tmp_path / "cache")
    out = io.BytesIO()
    arrays: dict[str, Any] = {kind: np.array([Planted(sign)], dtype=object) for kind in (*ARRAY_TYPES, TREE)}
    np.savez(out, **arrays)
    path.write_bytes(zlib.compress(hashlib.sha256(out.getvalue()).digest() + out.getvalue()))
    assert AssetStore(tmp_path / "cache").built(kettle, NUMBERS).digest == first.digest
    assert count.call_count == 2
    assert not sign.exists()


def never_again(monkeypatch: pytest.MonkeyPatch, module: object, name: str) -> None:
    """Have a function fail; a key of its source stays as it is."""

    @wraps(getattr(module, name))
    def never(asset: Asset, *_: object) -> None:
        raise AssertionError(asset.id)

    monkeypatch.setattr(module, name, never)


def test_light_forms_are_made_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asset = preset("fruit_bowl", next(iter(family("fruit_bowl").presets)))
    wanted = lighten(asset)
    assert wanted.digest != asset.digest
    assert AssetStore(tmp_path).lightened(asset).digest == wanted.digest
    never_again(monkeypatch, asset_store, "lighten")
    assert AssetStore(tmp_path).lightened(asset).digest == wanted.digest


def test_layers_are_written_once_for_each_content_and_folder_of_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    box = textured_box()
    inertial = box.root.inertial.replace(mass=2 * box.mass)
    heavier = box.replace(links=(box.root.replace(inertial=inertial),))
    for _ in range(2):
        for asset, textures in ((box, "./textures"), (box, "../../textures"), (heavier, "./textures")):
            assert AssetStore(tmp_path).layer_text(asset, textures) == document.layer_text(asset, textures)
    assert len(entries(tmp_path, "layers")) == 3
    wanted = document.layer_text(box, "./textures")
    never_again(monkeypatch, document, "layer_text")
    assert AssetStore(tmp_path).layer_text(box, "./textures") == wanted
