"""Libraries on servers that speak S3: the same bytes there and back, whoever is killed in the middle."""

from __future__ import annotations

import shutil
import subprocess
import time
from pathlib import Path

import pytest

from tests.support.library.libraries import entries_of, input_rows
from tests.support.library.object_stores import BUCKET, KEY, SECRET, Server, killed
from tests.support.library.sharded_inputs import public_differences
from tests.support.program.environments import wait_until

pytestmark = pytest.mark.consumers

# What the program does where something is killed does not hang on whose server it is: a release tries both.
one_server_in_ci = pytest.mark.parametrize(
    "server", ["seaweedfs", pytest.param("rclone", marks=pytest.mark.certify)], indirect=True
)


@pytest.fixture
def library(samples: Path, tmp_path: Path) -> Path:
    """The library of the sample meshes, to be changed."""
    place = shutil.copytree(samples / "out" / "library", tmp_path / "library", ignore=shutil.ignore_patterns(".casa"))
    (place / ".casa").mkdir()
    return place


def url(name: str) -> str:
    return f"s3://{BUCKET}/{name}"


def files_of(library: Path) -> list[str]:
    """Paths of all files of a library that others may see."""
    paths = (path.relative_to(library).as_posix() for path in library.rglob("*") if path.is_file())
    return sorted(path for path in paths if not path.startswith(".casa/"))


def half_pushed(server: Server, library: Path) -> subprocess.Popen[str]:
    """A push that is in its middle."""
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
    done = server.casa("library", "pull", url("lib"), tmp_path / "early")
    assert done.returncode == 2
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
        done = server.casa(*order, tmp_path / "one")
        assert done.returncode == 1, done.stderr
        assert public_differences(tmp_path / "one", boxes / "library") == []
        same_on(server, "lib", tmp_path / "one", tmp_path)
        done = server.casa(*order, tmp_path / "two", "--json")
        assert done.returncode == 1, done.stderr
        assert {row["kept"] for row in input_rows(done.stdout)} == {True}
        assert public_differences(tmp_path / "two", boxes / "library") == []
        same_on(server, "lib", tmp_path / "two", tmp_path / "again")


def test_what_cannot_work_is_told_and_no_secret_is(boxes: Path, tmp_path: Path) -> None:
    library = boxes / "library"
    with Server("rclone", tmp_path / "server") as server:
        wrong = server.casa("library", "push", library, url("lib"), AWS_SECRET_ACCESS_KEY="another")
        lacking = server.casa("library", "push", library, "s3://no-such-bucket/lib")
        done = server.casa("library", "push", library, url("lib"), "--verbose")
        assert done.returncode == 0, done.stderr
        server.kill()
        away = server.casa("library", "pull", url("lib"), tmp_path / "back")
    assert [wrong.returncode, lacking.returncode, away.returncode] == [2, 2, 2]
    assert "refuses" in wrong.stderr
    assert "make the bucket first" in lacking.stderr
    assert f"{url('lib')}: does not answer" in away.stderr
    assert "run again when it does" in away.stderr
    told = "".join(one.stdout + one.stderr for one in (wrong, lacking, done, away))
    written = b"".join(path.read_bytes() for path in (tmp_path / "server").rglob("*") if path.is_file())
    assert SECRET not in told
    assert KEY not in told
    assert SECRET.encode() not in written
