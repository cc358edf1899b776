"""The store gives back what was put, whole or not at all; where the cache is if it keeps nothing; the index of code."""

from __future__ import annotations

import multiprocessing
import os
import resource
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from casa_assets.cache import code_index
from casa_assets.cache.store import Store
from casa_assets.core.system import cache_for
from casa_assets.runs import engine as batch
from tests.support.library.libraries import write_files

KEY = "ab" * 32
Scans = Callable[[], dict[str, code_index.Scan]]  # what a new process would find in a package


@pytest.mark.parametrize("damage", [b"", b"not compressed", None])
def test_what_is_damaged_is_not_there(tmp_path: Path, damage: bytes | None) -> None:
    store = Store(tmp_path)
    store.put(KEY, b"x" * 1000)
    (path,) = (p for p in tmp_path.rglob("*") if p.is_file())
    path.write_bytes(path.read_bytes()[:-3] if damage is None else damage)
    assert store.get(KEY) is None


def test_a_write_that_is_cut_off_leaves_what_was_there(tmp_path: Path) -> None:
    """As on a disk that becomes full: no file may be larger than 1000 bytes."""
    store, limit = Store(tmp_path), resource.getrlimit(resource.RLIMIT_FSIZE)
    store.put(KEY, b"whole")
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limit[1]))
    try:
        with pytest.raises(OSError, match="large"):
            store.put(KEY, os.urandom(5000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert store.get(KEY) == b"whole"


def keys(store: Store) -> list[str]:
    return sorted(path.name for path in store.root.glob("*/*"))


def test_what_was_used_longest_ago_makes_room(tmp_path: Path) -> None:
    store = Store(tmp_path)
    for i in range(8):
        store.put(f"{i}" * 64, os.urandom(1000))
        os.utime(tmp_path / f"{i}{i}" / (f"{i}" * 64), (i, i))
    size = sum(path.stat().st_size for path in tmp_path.glob("*/*"))
    store.trim(size)
    assert len(keys(store)) == 8
    assert store.get("0" * 64) is not None  # the oldest, used now
    store.trim(size // 2)
    assert keys(store) == ["0" * 64, "6" * 64, "7" * 64]


def test_what_another_process_is_writing_stays_until_it_was_killed(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(KEY, os.urandom(1000))
    half = tmp_path / "ab" / f".{KEY}.123"
    half.write_bytes(b"half" * 1000)
    store.trim(0)
    assert half.exists()
    assert store.get(KEY) is None
    os.utime(half, (0, 0))  # whoever wrote it was killed
    store.trim(0)
    assert not half.exists()
    store.put(KEY, b"x")
    half.write_bytes(b"half")
    store.sweep()
    assert keys(store) == [KEY]


def test_only_an_optional_store_may_fail_to_keep_something(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    root = tmp_path / "file" / "store"
    optional = Store(root, is_optional=True)
    optional.put(KEY, b"x")
    optional.trim(0)
    assert optional.get(KEY) is None
    with pytest.raises(OSError, match="file"):
        Store(root).put(KEY, b"x")


def put_and_trim(root: Path, first: int) -> None:
    store = Store(root)
    for i in range(60):
        key = f"{first + i % 20:064x}"
        data = store.get(key)
        assert data in (None, key.encode() * 100)
        store.put(key, key.encode() * 100)
        store.trim(1500)


def test_processes_trim_one_store_side_by_side(tmp_path: Path) -> None:
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        pool.starmap(put_and_trim, [(tmp_path, 0), (tmp_path, 10)])
    assert sum(path.stat().st_size for path in tmp_path.glob("*/*")) <= 1500


@pytest.mark.parametrize("reason", ["cannot be written to", "is on a full disk"])
def test_a_cache_that_keeps_nothing_is_replaced_and_named(
    reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    wanted = tmp_path / "wanted"
    monkeypatch.setenv("CASA_ASSETS_CACHE", str(wanted / "cache"))
    if "disk" in reason:
        monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=1000))
    else:
        wanted.write_bytes(b"")  # the user who runs the tests may be root, who may write to every folder
    own = tmp_path / "out" / ".casa" / "cache"
    assert cache_for(tmp_path / "out") == own
    monkeypatch.setattr(batch, "open_engine", Mock(side_effect=KeyboardInterrupt))  # before a worker starts
    with pytest.raises(KeyboardInterrupt):
        next(batch.run_batch(shutil.rmtree, [tmp_path], tmp_path / "out", 1, "", 0))
    assert f"the cache folder {wanted / 'cache'} {reason}, so {own} is used instead" in caplog.text


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Scans]:
    monkeypatch.setenv("CASA_ASSETS_CACHE", str(tmp_path / "cache"))
    root, imports = tmp_path / "casa_assets", "from casa_assets.two import made\nimport numpy\n"
    write_files(root, {"__init__.py": "", "one.py": imports, "two.py": 'made = "table.yaml"\n'})
    monkeypatch.setattr(code_index, "package_root", lambda: root)

    def scans() -> dict[str, code_index.Scan]:
        code_index.package_files.cache_clear()
        code_index._scans.cache_clear()
        return code_index._scans()

    yield scans
    code_index.package_files.cache_clear()
    code_index._scans.cache_clear()


def test_only_a_changed_file_is_read_again(package: Scans, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_a_module_that_is_named_in_text_is_one_that_is_used(package: Scans, tmp_path: Path) -> None:
    """Workers are given what they do by its name."""
    (tmp_path / "casa_assets" / "one.py").write_text('WORK, OTHER = "casa_assets.two:made", "casa_assets.three:made"\n')
    assert package()["casa_assets.one"].modules == ("casa_assets.two",)


def test_a_new_module_or_a_damaged_index_has_all_read_again(package: Scans, tmp_path: Path) -> None:
    """What `from casa_assets.two import made` leads to depends on which modules there are."""
    before = package()
    for path in (tmp_path / "cache" / code_index.KEPT_IN).iterdir():
        path.write_bytes(path.read_bytes()[:40])
    assert package() == before
    (tmp_path / "casa_assets" / "two.py").unlink()
    write_files(tmp_path / "casa_assets" / "two", {"__init__.py": "", "made.py": ""})
    assert package()["casa_assets.one"].modules == ("casa_assets.two.made",)
