"""Tables (Parquet) of meshes: which rows are inputs, what they say, and what a broken table ends as.

Shards of WebDataset: what the JSON of a sample says of its mesh, and what a shard may hold.
"""

from __future__ import annotations

import gzip
import json
import random
import sys
import tarfile
from collections import Counter
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.sources import archive, rows
from casa_assets.ingest.sources.discover import collect
from casa_assets.ingest.sources.places import is_table
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import SourceKind
from tests.support.mesh.format_files import tarred
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
    write(tmp_path / "t.parquet", {"mesh": [None, b"", OBJ]})  # without bytes, and with too many
    found, _ = inputs_of(tmp_path)
    for one, code in zip(found, (codes.EMPTY_FILE, codes.EMPTY_FILE, codes.TOO_LARGE), strict=True):
        with pytest.raises(Rejected, match=code):
            collect(one, {**LIMITS, "input_bytes": 10})


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
    with pytest.raises(Rejected, match=codes.BAD_ARCHIVE):
        collect(found[2], LIMITS)


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
    with pytest.raises(Rejected, match=f"{codes.NEEDS_PYARROW}: .*pip install"):
        collect(one, LIMITS)
    assert is_table("a.PARQUET")


def shard(members: dict[str, bytes]) -> bytes:
    return gzip.decompress(tarred(**members))


@pytest.mark.parametrize("suffix", ["tar", "tar.gz"])
def test_a_sample_is_what_its_json_says(tmp_path: Path, suffix: str) -> None:
    said = {"uid": "m7", "name": "Blue mug", "category": "mug", "license": "by", "tags": ["cup"], "author": "Ann"}
    members = {
        "000001.obj": OBJ,
        "000001.json": json.dumps(said).encode(),
        "000001.txt": b"a mug",
        "000001.cls": b"3",
        "000001.png": b"no picture",
        "000002.json": b'{"title": "Kettle", "prompt": "a kettle", "__key__": "000002"}',
        "000002.obj": OBJ + b"# 2\n",
        "000003.obj": OBJ + b"# 3\n",
        "000004.json": b'{"name": "no mesh"}',
    }
    data = shard(members)
    (tmp_path / f"shard-000000.{suffix}").write_bytes(gzip.compress(data) if suffix == "tar.gz" else data)
    others: Counter[str] = Counter()
    found, refused = inputs_of(tmp_path, others)
    assert refused == []
    assert [one.source.path for one in found] == [f"shard-000000.{suffix}!00000{n}.obj" for n in (1, 2, 3)]
    mug, kettle, bare = (one.source for one in found)
    assert (mug.uid, mug.title, mug.category, mug.licence) == ("m7", "Blue mug", "mug", "CC-BY-4.0")
    assert (mug.author, mug.kind, mug.hints[:2]) == ("Ann", SourceKind.MANIFEST, ("Blue mug", "cup"))
    assert (kettle.uid, kettle.title, kettle.prompt, kettle.kind) == ("", "Kettle", "a kettle", SourceKind.TEXT_TO_3D)
    assert (bare.uid, bare.title, bare.kind) == ("", "", SourceKind.FOLDER)
    assert +others == {"texts": 1, "other files": 1, "pictures": 1, "tables and settings": 3}
    for one in found:
        assert len(load(collect(one, LIMITS), LIMITS).parts) == 1


def test_a_sample_that_is_wrong_is_refused_alone(subtests: pytest.Subtests, tmp_path: Path) -> None:
    for text, code in [
        (b"{broken", codes.BAD_ROW),
        (b"[1]", codes.BAD_ROW),
        (b'{"name": 7}', codes.BAD_ROW),
        (b'{"uid": "../../x"}', codes.BAD_ID),
        (b'{"uid": "taken"}', codes.DUPLICATE_ID),
        (b"[" * 100_000, codes.BAD_ROW),
        (b'{"name": "' + b"x" * (1 << 20) + b'"}', codes.TOO_LARGE),
    ]:
        with subtests.test(text=text, code=code):
            members = {"a.obj": OBJ, "a.json": b'{"uid": "taken"}', "b.obj": OBJ, "b.json": text, "c.obj": OBJ}
            (tmp_path / "s.tar").write_bytes(shard(members))
            found, refused = inputs_of(tmp_path)
            assert [one.main for one in found] == ["a.obj", "c.obj"]
            assert [(one.path, one.code) for one in refused] == [("s.tar", code)]
            assert refused[0].message.startswith("s.tar!b.json: ")


def test_the_json_of_a_shard_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive, "MAX_TEXTS_BYTES", 50)
    said = json.dumps({"name": "x" * 20}).encode()
    members = {f"{n}.{kind}": content for n in "abc" for kind, content in (("json", said), ("obj", OBJ))}
    (tmp_path / "s.tar").write_bytes(shard(members))
    found, refused = inputs_of(tmp_path)
    assert [one.main for one in found] == ["a.obj"]
    assert [one.code for one in refused] == [codes.TOO_LARGE] * 2


def test_a_member_is_read_where_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker reads one header, not those of all members before it."""
    (tmp_path / "s.tar").write_bytes(shard({f"{n:04}.obj": OBJ + b"# %d\n" % n for n in range(300)}))
    found, _ = inputs_of(tmp_path)
    headers: list[str] = []
    following = tarfile.TarFile.next

    def counted(archive: tarfile.TarFile) -> tarfile.TarInfo | None:
        info = following(archive)
        if info is not None:
            headers.append(info.name)
        return info

    monkeypatch.setattr(tarfile.TarFile, "next", counted)
    assert collect(found[250], LIMITS).files["0250.obj"].endswith(b"# 250\n")
    assert headers[0] == "0250.obj"
    # `next` returns the first member of each of the two archives twice, and reads it once.
    assert len(headers) - 2 == 301, "and the list of all, for an OBJ may have companions"


def test_a_tar_that_has_changed_is_searched(tmp_path: Path) -> None:
    (tmp_path / "s.tar").write_bytes(shard({"a.obj": OBJ, "b.obj": OBJ}))
    found, _ = inputs_of(tmp_path)
    (tmp_path / "s.tar").write_bytes(shard({"x.obj": OBJ, "y.obj": OBJ, "b.obj": OBJ + b"# new\n"}))
    assert collect(found[1], LIMITS).files["b.obj"].endswith(b"# new\n")
