"""registry/look_alikes.yaml as it comes with the package, and what a broken one says."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.errors import RegistryError
from casa_assets.registry.tables import LOOK_ALIKES_FILE, look_alikes


def test_shipped_rows_are_of_categories_of_objects_and_few() -> None:
    found = look_alikes()
    assert found["mug"] == found["coffee_cup"] != found["jug"]
    assert len(found) < 0.2 * len(registry.load().categories)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("cup: {categories: [mug, mugg], reason: x.}", "mugg"),
        ("cup: {categories: [mug], reason: x.}", "at least 2"),
        ("one: {categories: [mug, cup], reason: x.}\ntwo: {categories: [cup, bowl], reason: y.}", "no other row"),
    ],
)
def test_a_broken_row_is_refused_with_its_place(tmp_path: Path, text: str, expected: str) -> None:
    folder = tmp_path / "registry"
    shutil.copytree(registry.data_root(), folder)
    (folder / LOOK_ALIKES_FILE).write_text(text + "\n", encoding="utf-8")
    with pytest.raises(RegistryError, match=expected) as caught:
        look_alikes(folder)
    assert LOOK_ALIKES_FILE in str(caught.value)
