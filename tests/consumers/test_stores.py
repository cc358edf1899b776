"""Servers that speak S3, killed in the middle: libraries there and back, meshes whose library is that of a disk."""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
import time
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.support.library.libraries import BOXES, box_obj, casa, entries_of, input_rows
from tests.support.library.object_stores import BUCKET, KEY, SECRET, Server, killed
from tests.support.library.sharded_inputs import public_differences
from tests.support.mesh.format_files import tarred, zipped
from tests.support.program.environments import wait_until

pytestmark = pytest.mark.consumers

# What the program does where something is killed does not hang on whose server it is: a release tries both.
one_server_in_ci = pytest.mark.parametrize(
    "server", ["seaweedfs", pytest.param("rclone", marks=pytest.mark.certify)], indirect=True
)
# Where one server is enough; the other one takes any password.
only_rclone = pytest.mark.parametrize("server", ["rclone"], indirect=True)


@pytest.fixture
def library(samples: Path, tmp_path: Path) -> Path:
    place = shutil.copytree(samples / "out" / "library", tmp_path / "library", ignore=shutil.ignore_patterns(".casa"))
    (place / ".casa").mkdir()
    return place


def url(name: str) -> str:
    return f"s3://{BUCKET}/{name}"


def files_of(library: Path) -> list[str]:
    paths = (path.relative_to(library).as_posix() for path in library.rglob("*") if path.is_file())
    return sorted(path for path in paths if not path.startswith(".casa/"))


def half_pushed(server: Server, library: Path) -> subprocess.Popen[str]:
    before = server.size
    run = server.begin("library", "push", library, url("lib"))
    wait_until(lambda: server.size > before + 2_000_000, run)
    return run


def same_on(server: Server, name: str, library: Path, tmp_path: Path) -> None:
    """Check that a store has the files of a library, none twice and none lost, and gives the same bytes back."""
    assert server.keys(name) == files_of(library)
    server.done("library", "pull", url(name), tmp_path / f"back_{name}")
    assert public_differences(tmp_path / f"back_{name}", library) == []


def test_there_and_back(server: Server, library: Path, tmp_path: Path) -> None:
    assert f"{len(entries_of(library))} copied" in server.done("library", "push", library, url("lib"))
    same_on(server, "lib", library, tmp_path)
    printed = server.done("library", "push", library, url("lib"), "--json")
    assert printed.count('"verdict": "kept"') == printed.count("\n") == len(entries_of(library)) > 10


@one_server_in_ci
def test_a_server_that_is_killed_in_the_middle_and_started_again(server: Server, library: Path, tmp_path: Path) -> None:
    run = half_pushed(server, library)
    server.kill()
    time.sleep(3.0)
    assert run.poll() is None
    server.start()
    out, errors = run.communicate(timeout=300)
    assert run.returncode == 0, out + errors
    same_on(server, "lib", library, tmp_path)


@one_server_in_ci
def test_a_push_that_is_killed_in_the_middle_is_finished_by_the_next(
    server: Server, library: Path, tmp_path: Path
) -> None:
    run = half_pushed(server, library)
    killed(run)
    left = server.keys("lib")
    assert ".casa/unfinished.json" in left
    done = server.casa("library", "pull", url("lib"), tmp_path / "early", code=2)
    assert "was cut off before it had ended" in done.stderr
    server.done("library", "pull", url("lib"), tmp_path / "early", "--partial")
    assert set(entries_of(tmp_path / "early")) < set(entries_of(library))
    server.done("library", "push", library, url("lib"))
    same_on(server, "lib", library, tmp_path)


def test_ingest_keeps_its_library_on_a_store(boxes: Path, tmp_path: Path) -> None:
    """The server is killed in the middle of the first run, the second run is killed, the third is another machine."""
    order = ("ingest", boxes / "in", "--jobs", 1, "--store", url("lib"), "--library")
    with Server("seaweedfs", tmp_path / "server") as server:
        run = server.begin(*order, tmp_path / "one")
        wait_until(lambda: len(list((tmp_path / "one").glob("*/*/asset.json"))) > 0, run)
        server.kill()
        time.sleep(3.0)
        server.start()
        wait_until(lambda: len(list((tmp_path / "one").glob("*/*/asset.json"))) > 1, run)
        killed(run)
        server.casa(*order, tmp_path / "one", code=1)
        assert public_differences(tmp_path / "one", boxes / "library") == []
        same_on(server, "lib", tmp_path / "one", tmp_path)
        done = server.casa(*order, tmp_path / "two", "--json", code=1)
        assert {row["kept"] for row in input_rows(done.stdout)} == {True}
        assert public_differences(tmp_path / "two", boxes / "library") == []
        same_on(server, "lib", tmp_path / "two", tmp_path / "again")


def test_what_cannot_work_is_told_and_no_secret_is(boxes: Path, tmp_path: Path) -> None:
    library = boxes / "library"
    with Server("rclone", tmp_path / "server") as server:
        wrong = server.casa("library", "push", library, url("lib"), code=2, AWS_SECRET_ACCESS_KEY="another")
        lacking = server.casa("library", "push", library, "s3://no-such-bucket/lib", code=2)
        done = server.casa("library", "push", library, url("lib"), "--verbose", code=0)
        server.kill()
        away = server.casa("library", "pull", url("lib"), tmp_path / "back", code=2)
    assert "refuses" in wrong.stderr
    assert "make the bucket first" in lacking.stderr
    assert f"{url('lib')}: does not answer" in away.stderr
    assert "run again when it does" in away.stderr
    told = "".join(one.stdout + one.stderr for one in (wrong, lacking, done, away))
    written = b"".join(path.read_bytes() for path in (tmp_path / "server").rglob("*") if path.is_file())
    assert SECRET not in told
    assert KEY not in told
    assert SECRET.encode() not in written


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
    done = casa("ingest", folder, "--library", root / "library", "--json", code=1)
    return Made(folder, root / "library", done.stdout)


@pytest.fixture
def things(server: Server, on_disk: Made) -> Made:
    text = f"import s3fs; s3fs.S3FileSystem().put({str(on_disk.things)!r}, {BUCKET!r}, recursive=True)"
    server.python(text, code=0)
    return on_disk


def verdicts(printed: str) -> list[tuple[str, str]]:
    return sorted((row["path"], row["verdict"]) for row in input_rows(printed))


def test_the_library_is_that_of_the_disk(server: Server, things: Made, tmp_path: Path) -> None:
    done = server.casa("ingest", url("things"), "--library", tmp_path / "s3", "--json", code=1)
    assert verdicts(done.stdout) == verdicts(things.printed)
    assert public_differences(things.library, tmp_path / "s3") == []
    again = server.casa("ingest", url("things"), "--library", tmp_path / "s3", "--json")
    assert {row["kept"] for row in input_rows(again.stdout)} == {True}
    for path in (tmp_path / "s3").rglob("*"):
        assert not path.is_file() or SECRET.encode() not in path.read_bytes(), path


@only_rclone
def test_a_server_that_is_away_rejects_and_ends_nothing_for_good(server: Server, things: Made, tmp_path: Path) -> None:
    run = server.begin("ingest", url("things"), "--library", tmp_path / "s3", "--json", "--jobs", 1)
    wait_until(lambda: list((tmp_path / "s3").glob("*/*/asset.json")), run)
    server.kill()
    out, errors = run.communicate(timeout=600)
    assert run.returncode == 1, errors
    codes = {row["code"] for row in input_rows(out)}
    assert codes <= {"", "SRC012", "SRC013", "SRC035"}, codes
    gone = server.casa("ingest", url("things"), "--library", tmp_path / "none", code=2)
    assert url("things") in gone.stderr
    server.start()
    server.casa("ingest", url("things"), "--library", tmp_path / "s3", "--json", code=1)
    assert public_differences(things.library, tmp_path / "s3") == []


@only_rclone
@pytest.mark.usefixtures("things")
def test_an_address_without_rights_or_objects_is_told(server: Server, tmp_path: Path) -> None:
    for address, words in ((url("nothing"), "nothing at this address"), ("s3://none/x", "s3://none/x")):
        done = server.casa("ingest", address, "--library", tmp_path / "none", code=2)
        assert words in done.stderr
    words = ("ingest", url("things"), "--library", tmp_path / "none")
    done = server.casa(*words, code=2, AWS_SECRET_ACCESS_KEY="wrong")
    assert "may not be read; give the credentials" in done.stderr
