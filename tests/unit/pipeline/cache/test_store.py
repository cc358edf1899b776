"""The store gives back what was put, whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from casa_assets.pipeline.cache.store import Store

KEY = "ab" * 32


def test_put_and_get(tmp_path: Path) -> None:
    store = Store(tmp_path)
    assert store.get(KEY) is None
    store.put(KEY, b"first")
    store.put(KEY, b"second")
    assert store.get(KEY) == b"second"
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == [KEY]


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
