"""Meshes on servers that speak S3: the library of the same folder on the disk, also where the server is away."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.support.library.libraries import BOXES, box_obj, casa, input_rows
from tests.support.library.object_stores import BUCKET, SECRET, Server
from tests.support.library.sharded_inputs import public_differences
from tests.support.mesh.format_files import tarred, zipped
from tests.support.program.environments import wait_until

pytestmark = pytest.mark.consumers

URL = f"s3://{BUCKET}/things"
# Where one server is enough; the other one takes any password.
only_rclone = pytest.mark.parametrize("server", ["rclone"], indirect=True)


class Made(NamedTuple):
    """A folder of meshes on the disk, the library of it, and what the run printed; only to read."""

    things: Path
    library: Path
    printed: str


@pytest.fixture(scope="module")
def on_disk(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A folder with a loose mesh, a shard, a table and an archive, and what becomes of it."""
    root = tmp_path_factory.mktemp("on_disk")
    folder = root / "in" / "things"
    (folder / "deep").mkdir(parents=True)
    boxes = {name: box_obj(size).encode() for name, size in BOXES.items()}
    said = json.dumps({"category": "cutting_board", "license": "cc0"}).encode()
    (folder / "cereal_box.obj").write_bytes(boxes["cereal_box"])
    shard = tarred(**{"000001.json": said, "000001.obj": boxes["cutting_board"]})
    (folder / "shard-000000.tar").write_bytes(gzip.decompress(shard))
    pq.write_table(pa.table({"id": ["carton"], "obj": [boxes["milk_carton"]]}), folder / "t.parquet")
    (folder / "deep" / "pack.zip").write_bytes(zipped(**{"empty.obj": b"v 0 0 0\n"}))
    done = casa("ingest", folder, "--library", root / "library", "--json")
    assert done.returncode == 1, done.stderr
    return Made(folder, root / "library", done.stdout)


@pytest.fixture
def things(server: Server, on_disk: Made) -> Made:
    """The same folder on the disk and on the store."""
    put = f"import s3fs; s3fs.S3FileSystem().put({str(on_disk.things)!r}, {BUCKET!r}, recursive=True)"
    done = server.python(put)
    assert done.returncode == 0, done.stderr
    return on_disk


def verdicts(printed: str) -> list[tuple[str, str]]:
    return sorted((row["path"], row["verdict"]) for row in input_rows(printed))


def test_the_library_is_that_of_the_disk(server: Server, things: Made, tmp_path: Path) -> None:
    done = server.casa("ingest", URL, "--library", tmp_path / "s3", "--json")
    assert done.returncode == 1, done.stderr
    assert verdicts(done.stdout) == verdicts(things.printed)
    assert public_differences(things.library, tmp_path / "s3") == []
    again = server.casa("ingest", URL, "--library", tmp_path / "s3", "--json")
    assert {row["kept"] for row in input_rows(again.stdout)} == {True}
    for path in (tmp_path / "s3").rglob("*"):
        assert not path.is_file() or SECRET.encode() not in path.read_bytes(), path


@only_rclone
def test_a_server_that_is_away_rejects_and_ends_nothing_for_good(server: Server, things: Made, tmp_path: Path) -> None:
    run = server.begin("ingest", URL, "--library", tmp_path / "s3", "--json", "--jobs", 1)
    wait_until(lambda: list((tmp_path / "s3").glob("*/*/asset.json")), run)
    server.kill()
    out, errors = run.communicate(timeout=600)
    assert run.returncode == 1, errors
    codes = {row["code"] for row in input_rows(out)}
    assert codes <= {"", "SRC012", "SRC013", "SRC035"}, codes
    gone = server.casa("ingest", URL, "--library", tmp_path / "none")
    assert (gone.returncode, URL in gone.stderr) == (2, True), gone.stderr
    server.start()
    done = server.casa("ingest", URL, "--library", tmp_path / "s3", "--json")
    assert done.returncode == 1, done.stderr
    assert public_differences(things.library, tmp_path / "s3") == []


@only_rclone
@pytest.mark.usefixtures("things")
def test_an_address_without_rights_or_objects_is_told(server: Server, tmp_path: Path) -> None:
    for address, words in ((f"s3://{BUCKET}/nothing", "nothing at this address"), ("s3://none/x", "s3://none/x")):
        done = server.casa("ingest", address, "--library", tmp_path / "none")
        assert done.returncode == 2
        assert words in done.stderr
    done = server.casa("ingest", URL, "--library", tmp_path / "none", AWS_SECRET_ACCESS_KEY="wrong")
    assert done.returncode == 2
    assert "may not be read; give the credentials" in done.stderr
