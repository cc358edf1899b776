"""Wheels, and environments of Python that have nothing of this checkout but the wheels installed in them."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path


def build_wheel(project: Path, folder: Path) -> Path:
    """The wheel of a project, put into a folder; its build backend is downloaded where pip has not kept it."""
    _run([sys.executable, "-m", "build", "--wheel", "--outdir", str(folder), str(project)])
    (built,) = folder.glob("*.whl")
    return built


@dataclass(frozen=True)
class Environment:
    """An environment of Python, made by `install`. folder: where it stands."""

    folder: Path

    def casa(self, *words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
        """Call the command `casa-assets` of the environment."""
        return self._call("casa-assets", *words, cwd=cwd)

    def python(self, script: Path, cwd: Path) -> subprocess.CompletedProcess[str]:
        """Run a script with the Python of the environment."""
        return self._call("python", script, cwd=cwd)

    def _call(self, program: str, *words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
        command = [str(self.folder / "bin" / program), *map(str, words)]
        return subprocess.run(command, cwd=cwd, env=self._variables(), capture_output=True, text=True, check=False)

    def _variables(self) -> dict[str, str]:
        """Nothing leads to the checkout or a project, and the user has no configuration; the cache is that of tests."""
        left_out = [name for name in os.environ if name.startswith(("PYTHON", "CASA_ASSETS_"))]
        kept = {name: value for name, value in os.environ.items() if name not in left_out}
        own = {"XDG_CONFIG_HOME": str(self.folder / "config"), "COLUMNS": "200"}
        return {**kept, **own, "CASA_ASSETS_CACHE": os.environ["CASA_ASSETS_CACHE"]}


def install(folder: Path, *wheels: Path) -> Environment:
    """Make an environment with wheels in it. What these depend on comes from the environment that runs the tests."""
    _run([sys.executable, "-m", "venv", "--without-pip", str(folder)])
    python = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", str(python), "--disable-pip-version-check", "--quiet"]
    _run([*pip, "install", "--no-deps", "--no-index", *map(str, wheels)])
    (site,) = folder.glob("lib/python*/site-packages")
    # A folder that a .pth file names is searched, but .pth files in it are not read: the editable installation of the
    # checkout, which is such a file, stays out.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return Environment(folder)


def _run(command: list[str]) -> None:
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr or done.stdout
