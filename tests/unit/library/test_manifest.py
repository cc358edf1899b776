"""An asset is its asset.json and the files beside it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.library.library import asset_from_manifest, manifest_of
from casa_assets.model.asset.asset import Asset
from tests.support.asset.assets import EVERY, textured_box
from tests.support.asset.packages import written


def test_round_trip(subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory) -> None:
    for make in EVERY:
        with subtests.test(make=make.__name__):
            tmp_path = tmp_path_factory.mktemp("case")
            asset = make()
            package = written(asset, tmp_path)
            text = json.dumps(manifest_of(asset))
            back = asset_from_manifest(json.loads(text), package.root)
            assert back.digest == written_precision(asset, package.root, text)
            assert "base64" not in text, "meshes and pictures are files"


def written_precision(asset: Asset, folder: Path, text: str) -> str:
    """Digest of what the files say: they hold float32, so a second trip through them changes nothing."""
    once = asset_from_manifest(json.loads(text), folder)
    return asset_from_manifest(json.loads(json.dumps(manifest_of(once))), folder).digest


def test_a_missing_file_and_damaged_data_are_errors(tmp_path: Path) -> None:
    package, data = written(textured_box(), tmp_path), manifest_of(textured_box())
    for change in ({"links": None}, {"links": [{}]}, {"materials": 3}, {"surprise": 1}):
        with pytest.raises(OutputError, match="damaged"):
            asset_from_manifest({**data, **change}, package.root)
    for path in ("meshes/*.obj", "usd/textures/*.png"):
        file = next(package.root.glob(path))
        kept = file.read_bytes()
        file.unlink()
        with pytest.raises(OutputError, match="damaged"):
            asset_from_manifest(data, package.root)
        file.write_bytes(kept)
