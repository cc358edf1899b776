"""One cache for Python and the command line; if it cannot be written to, a folder beside the output replaces it."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from casa_assets.core.system import cache_for
from casa_assets.runs import engine as batch


class Stopped(Exception):
    """Ends a run before a worker starts."""


def stop(*_: object) -> None:
    raise Stopped


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
    monkeypatch.setattr(batch, "open_engine", stop)
    with pytest.raises(Stopped):
        next(batch.run_batch(shutil.rmtree, [tmp_path], tmp_path / "out", 1, "", 0))
    assert f"the cache folder {wanted / 'cache'} {reason}, so {own} is used instead" in caplog.text
