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


def test_it_takes_the_first_of_a_category_or_what_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for words, code, fetched in (
        (("--lvis", "mug", "--most", "1", "--out", str(tmp_path)), 0, ["a" * 32]),
        (("c" * 32, "--out", str(tmp_path)), 0, ["c" * 32]),
        ((), 2, []),
    ):
        package = Objaverse()
        monkeypatch.setitem(sys.modules, "objaverse", package)
        done = CliRunner().invoke(app, ["fetch", *words])
        assert (done.exit_code, package.fetched) == (code, fetched)
        assert code or f"casa-assets ingest {tmp_path / 'hf-objaverse-v1'}" in done.output
