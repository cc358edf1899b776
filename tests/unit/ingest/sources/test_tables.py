"""Tables (Parquet) of meshes: which rows are inputs, what they say, and what a broken table ends as."""

from __future__ import annotations

import random
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.sources import rows
from casa_assets.ingest.sources.discover import collect
from casa_assets.ingest.sources.places import is_table
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import SourceKind
from tests.support.mesh.mesh_files import LIMITS, OBJ_TRIANGLE, inputs_of

pytestmark = pytest.mark.content("code", "ingest.sources", keep=0)

OBJ = OBJ_TRIANGLE.encode()


def meshes(count: int) -> list[bytes]:
    return [OBJ + b"# %d\n" % number for number in range(count)]


def write(path: Path, columns: dict[str, Any], **options: Any) -> Path:
    pq.write_table(pa.table(columns), path, **options)
    return path


def test_each_row_is_an_input_with_what_its_columns_say(tmp_path: Path) -> None:
    columns = {
        "uid": ["m1", "m2", "m3"],
        "mesh": meshes(3),
        "format": ["obj", "OBJ", ".obj"],
        "name": ["Blue mug", None, "Pan"],
        "category": ["mug", "kettle", None],
        "license": ["by", None, "cc0"],
        "tags": [["cup"], None, []],
        "count": [1, 2, 3],
    }
    write(tmp_path / "t.parquet", columns)
    found, refused = inputs_of(tmp_path)
    assert refused == []
    assert [one.source.path for one in found] == [f"t.parquet!m{n}.obj" for n in (1, 2, 3)]
    mug, kettle, pan = (one.source for one in found)
    assert (mug.uid, mug.title, mug.category, mug.licence) == ("m1", "Blue mug", "mug", "CC-BY-4.0")
    assert (mug.kind, mug.hints[:2], kettle.title) == (SourceKind.MANIFEST, ("Blue mug", "cup"), "")
    assert (pan.licence, pan.category) == ("CC0-1.0", "")
    for one, data in zip(found, meshes(3), strict=True):
        assert collect(one, LIMITS).files[one.main] == data
        assert len(load(collect(one, LIMITS), LIMITS).parts) == 1


def test_a_row_that_is_wrong_is_refused_alone(tmp_path: Path) -> None:
    write(tmp_path / "t.parquet", {"mesh": meshes(3), "uid": ["a", "a", "../b"]})
    found, refused = inputs_of(tmp_path)
    assert [one.source.uid for one in found] == ["a"]
    assert [(one.path, one.code) for one in refused] == [("t.parquet", c) for c in (codes.DUPLICATE_ID, codes.BAD_ID)]
    assert "row 1" in refused[0].message


def test_a_row_without_bytes_or_with_too_many_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "t.parquet", {"mesh": [None, b"", OBJ]})
    found, _ = inputs_of(tmp_path)
    for one, code in zip(found, (codes.EMPTY_FILE, codes.EMPTY_FILE, codes.TOO_LARGE), strict=True):
        with pytest.raises(Rejected) as refused:
            collect(one, {**LIMITS, "input_bytes": 10})
        assert refused.value.code == code


def test_broken_tables_are_refused_and_end_nothing(tmp_path: Path) -> None:
    whole = write(tmp_path / "whole.parquet", {"mesh": meshes(20), "name": ["x"] * 20}).read_bytes()
    noise = random.Random(1)
    (tmp_path / "a.obj").write_bytes(OBJ)
    broken = {"cut": whole[:-30], "empty": b"", "text": b"PAR1 no table", "head": whole[:-8] + b"\xff\xff\xff\x7fPAR1"}
    for number in range(2):
        data = bytearray(whole)
        for _ in range(20):
            data[noise.randrange(len(data) - 600, len(data) - 8)] = noise.randrange(256)
        broken[f"noise{number}"] = bytes(data)
    for name, data in broken.items():
        (tmp_path / f"{name}.parquet").write_bytes(data)
    (tmp_path / "whole.parquet").unlink()
    found, refused = inputs_of(tmp_path)
    assert "a.obj" in [one.main for one in found]
    known = {one.path: one.code for one in refused}
    assert [known[f"{name}.parquet"] for name in ("cut", "empty", "text")] == [codes.BAD_ARCHIVE] * 3
    assert known["head.parquet"] == codes.TOO_LARGE
    assert set(known.values()) <= {codes.BAD_ARCHIVE, codes.TOO_LARGE, codes.BAD_ROW, codes.WRONG_TYPE}


def test_a_table_that_has_changed_meanwhile_gives_no_other_bytes(tmp_path: Path) -> None:
    write(tmp_path / "t.parquet", {"mesh": meshes(3)})
    found, _ = inputs_of(tmp_path)
    write(tmp_path / "t.parquet", {"mesh": meshes(1)})
    with pytest.raises(Rejected) as refused:
        collect(found[2], LIMITS)
    assert refused.value.code == codes.BAD_ARCHIVE


def test_rows_beyond_what_a_run_holds_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "MAX_ROWS", 3)
    write(tmp_path / "t.parquet", {"mesh": meshes(5)})
    found, refused = inputs_of(tmp_path)
    assert len(found) == 3
    assert [one.code for one in refused] == [codes.TOO_LARGE]


def test_without_pyarrow_a_table_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "t.parquet", {"mesh": meshes(1)})
    (one,), _ = inputs_of(tmp_path)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(Rejected, match="pip install") as refused:
        collect(one, LIMITS)
    assert refused.value.code == codes.NEEDS_PYARROW
    assert is_table("a.PARQUET")
