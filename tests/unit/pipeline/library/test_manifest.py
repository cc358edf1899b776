"""An asset is its asset.json and the files beside it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.model.asset.asset import Asset
from casa_assets.pipeline.library.asset_json import asset_from_manifest, manifest_of
from tests.assets import EVERY, textured_box
from tests.packages import written


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


@pytest.mark.parametrize("path", ["meshes/*.obj", "usd/textures/*.png"])
def test_a_missing_file_is_an_error(path: str, tmp_path: Path) -> None:
    asset = textured_box()
    package = written(asset, tmp_path)
    data = manifest_of(asset)
    for file in package.root.glob(path):
        file.unlink()
    with pytest.raises(OutputError, match="damaged"):
        asset_from_manifest(data, package.root)


def test_damaged_data_is_an_error(subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory) -> None:
    for change in [{"links": None}, {"links": [{}]}, {"materials": 3}, {"surprise": 1}]:
        with subtests.test(change=change):
            tmp_path = tmp_path_factory.mktemp("case")
            package = written(textured_box(), tmp_path)
            with pytest.raises(OutputError, match="damaged"):
                asset_from_manifest({**manifest_of(textured_box()), **change}, package.root)
