"""Whole runs over sources on a store: the library of the same folder on the disk, file by file."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from casa_assets.ingest.run.run import Options, ingest
from casa_assets.ingest.run.shards import SHARD_FILE, Shard
from casa_assets.ingest.sources.places import root_of
from tests.support.library.libraries import BOXES, box_obj
from tests.support.library.sharded_inputs import public_differences
from tests.support.library.source_stores import web_server
from tests.support.mesh.format_files import tarred

pytestmark = [pytest.mark.content("code", "ingest.sources", keep=0), pytest.mark.content("code", "ingest.run", keep=0)]

# Refused without a mesh, refused once read, and refused for its form: nothing that takes long.
SHEET = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def make_sources(folder: Path) -> Path:
    folder.mkdir(parents=True)
    said = json.dumps({"category": "cutting_board", "name": "Oak"}).encode()
    board = box_obj(BOXES["cutting_board"]).encode()
    shard = gzip.decompress(tarred(**{"1.json": said, "1.obj": board, "2.json": b"{", "2.obj": board + b"#\n"}))
    (folder / "shard-000000.tar").write_bytes(shard)
    pq.write_table(pa.table({"id": ["cut"], "glb": [b"glTF\x02\0\0\0\xff\0\0\0"]}), folder / "t.parquet")
    (folder / "sheet.obj").write_bytes(SHEET)
    return folder


@pytest.mark.slow
def test_a_run_over_a_store_makes_the_library_of_the_disk(tmp_path: Path) -> None:
    make_sources(tmp_path / "in/things")
    disk = list(ingest([tmp_path / "in/things"], Options(tmp_path / "disk", jobs=1)))
    assert sorted(event.kind for event in disk) == ["accepted", "rejected", "rejected", "rejected"]
    log: list[str] = []
    with web_server(tmp_path / "in", log=log) as url:
        roots = [root_of(f"{url.replace('//', '//ann:pass@')}/things/?key=secret")]
        events = list(ingest(roots, Options(tmp_path / "store", jobs=1)))
        assert [event.kind for event in events] == [event.kind for event in disk]
        assert public_differences(tmp_path / "disk", tmp_path / "store") == []
        log.clear()
        again = list(ingest(roots, Options(tmp_path / "store", jobs=1)))
        assert {event.kind for event in again} == {"kept"}
        assert not any(line.startswith('"GET') and "sheet.obj" in line for line in log), "read although it is known"
        list(ingest(roots, Options(tmp_path / "shard", jobs=1, shard=Shard(1, 1000))))
    assert url in (tmp_path / "shard" / SHARD_FILE).read_text()
    for path in tmp_path.rglob("*"):
        if path.is_file() and not path.is_relative_to(tmp_path / "in"):
            data = path.read_bytes()
            assert b"ann:pass" not in data, path
            assert b"key=secret" not in data, path
