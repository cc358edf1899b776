"""The kept index of sources says what the sources say now."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from casa_assets.cache import code_index


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], dict[str, code_index.Scan]]]:
    """A package of two modules in `tmp_path`, and what a new process would find in it."""
    monkeypatch.setenv("CASA_ASSETS_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "casa_assets"
    root.mkdir()
    (root / "__init__.py").touch()
    (root / "one.py").write_text("from casa_assets.two import made\nimport numpy\n")
    (root / "two.py").write_text('made = "table.yaml"\n')
    monkeypatch.setattr(code_index, "package_root", lambda: root)

    def scans() -> dict[str, code_index.Scan]:
        code_index.package_files.cache_clear()
        code_index._scans.cache_clear()
        return code_index._scans()

    yield scans
    code_index.package_files.cache_clear()
    code_index._scans.cache_clear()


def test_only_a_changed_file_is_read_again(
    package: Callable[[], dict[str, code_index.Scan]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = package()
    read: list[str] = []
    theirs = code_index._scan_text
    monkeypatch.setattr(code_index, "_scan_text", lambda name, text: read.append(name) or theirs(name, text))
    assert package() == before
    assert read == []
    (tmp_path / "casa_assets" / "two.py").write_text('made = "plans.yaml"\n')
    after = package()
    assert read == ["casa_assets.two"]
    assert after["casa_assets.two"].words == ("plans.yaml",)
    assert after["casa_assets.one"] == before["casa_assets.one"]


def test_a_new_module_has_all_read_again(package: Callable[[], dict[str, code_index.Scan]], tmp_path: Path) -> None:
    """What `from casa_assets.two import made` leads to depends on which modules there are."""
    package()
    (tmp_path / "casa_assets" / "two.py").unlink()
    (tmp_path / "casa_assets" / "two").mkdir()
    (tmp_path / "casa_assets" / "two" / "__init__.py").touch()
    (tmp_path / "casa_assets" / "two" / "made.py").touch()
    assert package()["casa_assets.one"].modules == ("casa_assets.two.made",)


def test_a_damaged_index_is_made_again(package: Callable[[], dict[str, code_index.Scan]], tmp_path: Path) -> None:
    before = package()
    for path in (tmp_path / "cache" / code_index.KEPT_IN).iterdir():
        path.write_bytes(path.read_bytes()[:40])
    assert package() == before
