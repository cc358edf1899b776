"""The store gives back what was put, whole or not at all."""

from __future__ import annotations

import multiprocessing
import os
from pathlib import Path

import pytest

from casa_assets.cache.store import Store

KEY = "ab" * 32


@pytest.mark.parametrize("damage", [b"", b"not compressed", None])
def test_what_is_damaged_is_not_there(tmp_path: Path, damage: bytes | None) -> None:
    store = Store(tmp_path)
    store.put(KEY, b"x" * 1000)
    (path,) = (p for p in tmp_path.rglob("*") if p.is_file())
    path.write_bytes(path.read_bytes()[:-3] if damage is None else damage)
    assert store.get(KEY) is None


def test_sweep_takes_what_killed_writers_left(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(KEY, b"x")
    (tmp_path / "ab" / f".{KEY}.123").write_bytes(b"half")
    store.sweep()
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == [KEY]


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


def test_what_another_process_is_writing_stays(tmp_path: Path) -> None:
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
