"""What the command line says about libraries on stores; tests/consumers/test_stores.py has servers."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from casa_assets.cli.main import app
from casa_assets.errors import OutputError
from tests.support.library.sharded_inputs import public_differences


def casa(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def test_a_folder_is_a_store(boxes: Path, tmp_path: Path) -> None:
    pushed = casa("library", "push", boxes / "library", tmp_path / "store")
    assert pushed.exit_code == 0, pushed.output
    assert pushed.output.startswith("Store: ")
    assert "5 copied; " in pushed.output
    assert "5 kept; 0.0 MB" in casa("library", "push", boxes / "library", f"file://{tmp_path}/store").output
    pulled = casa("library", "pull", tmp_path / "store", tmp_path / "back", "-v")
    assert pulled.exit_code == 0, pulled.output
    assert f"Library: {tmp_path}/back: 5 copied; " in pulled.output
    assert public_differences(tmp_path / "back", boxes / "library") == []


def test_what_one_side_lacks_is_removed_on_request(boxes: Path, tmp_path: Path) -> None:
    casa("library", "push", boxes / "library", tmp_path / "store")
    shutil.copytree(boxes / "library", tmp_path / "less")
    shutil.rmtree(tmp_path / "less" / "milk")
    refused = casa("library", "push", tmp_path / "less", tmp_path / "store")
    assert isinstance(refused.exception, OutputError)
    assert "has an entry that" in str(refused.exception)
    done = casa("library", "push", tmp_path / "less", tmp_path / "store", "--delete")
    assert done.exit_code == 0, done.output
    assert "4 kept, 1 removed" in done.output
    assert not (tmp_path / "store" / "milk").exists()


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("https://someone:secret@example.org/lib", r"^https://example\.org/lib: is no store that can be written to"),
        ("simplecache::s3://bucket/lib", "is no store that can be written to"),
        ("nothing://bucket/lib", "nothing://bucket/lib: is no address of a store"),
    ],
)
def test_what_is_no_store_is_told(boxes: Path, url: str, message: str) -> None:
    done = casa("library", "push", boxes / "library", url)
    assert isinstance(done.exception, OutputError)
    with pytest.raises(OutputError, match=message):
        raise done.exception
    assert "secret" not in str(done.exception)


def test_the_address_of_a_store_is_no_folder(boxes: Path) -> None:
    done = casa("ingest", boxes / "in", "--library", "s3://bucket/library")
    assert done.exit_code == 2
    assert "is the address of a store" in " ".join(done.output.split())
    assert not Path("s3:").exists()


def test_options_that_do_not_go_together(boxes: Path, tmp_path: Path) -> None:
    words = ("--library", tmp_path / "new", "--store", tmp_path / "store", "--dry-run")
    done = casa("ingest", boxes / "in", *words)
    assert done.exit_code == 2, done.output
    assert "does not go with --dry-run" in done.output
    assert not (tmp_path / "store").exists()
