"""A verb that needs what is optional says so before it works, and ends with the exit code of a user's error."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

WITHOUT_PYARROW = """
import importlib.util, sys

find_spec = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name == "pyarrow" else find_spec(name, *more)
from casa_assets.cli.main import main

main()
"""


def test_parquet_without_pyarrow(tmp_path: Path) -> None:
    library = tmp_path / "library"
    (library / ".casa").mkdir(parents=True)
    command = ["library", "index", str(library), "--out", str(tmp_path / "tables")]
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_PYARROW, *command], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert "extra 'parquet'" in done.stderr
    assert "-m pip install" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "tables").exists()
