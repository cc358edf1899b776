"""`casa-assets fetch` hands its words to the `objaverse` package and says what to do next."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest
from typer.testing import CliRunner

from casa_assets.cli.main import app


class Objaverse(ModuleType):
    """Stands in for the package: two mugs, no network."""

    def __init__(self) -> None:
        super().__init__("objaverse")
        self.fetched: list[str] = []

    def load_lvis_annotations(self) -> dict[str, list[str]]:
        return {"Mug": ["b" * 32, "a" * 32], "Bowl": ["c" * 32]}

    def load_objects(self, uids: list[str]) -> None:
        self.fetched += uids

    def load_annotations(self, uids: list[str]) -> None:
        assert uids == self.fetched


@pytest.fixture
def package(monkeypatch: pytest.MonkeyPatch) -> Objaverse:
    stand_in = Objaverse()
    monkeypatch.setitem(sys.modules, "objaverse", stand_in)
    return stand_in


def test_first_of_a_category(package: Objaverse, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["fetch", "--lvis", "mug", "--most", "1", "--out", str(tmp_path)])
    assert done.exit_code == 0
    assert package.fetched == ["a" * 32]
    assert f"casa-assets ingest {tmp_path / 'hf-objaverse-v1'}" in done.output


def test_named_objects(package: Objaverse, tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["fetch", "c" * 32, "--out", str(tmp_path)]).exit_code == 0
    assert package.fetched == ["c" * 32]


def test_nothing_named_is_misuse(package: Objaverse) -> None:
    assert CliRunner().invoke(app, ["fetch"]).exit_code == 2
    assert package.fetched == []
