"""Environments of other programs, which `./dev consumers` makes, and those that have nothing of ours but wheels."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.support.library.libraries import ROOT

CONSUMERS = ROOT / "tests" / "consumers"


def python_of(name: str) -> Path:
    """Its Python; the variable names that file."""
    python = ROOT / os.environ.get(f"CASA_{name.upper()}", f".venv-{name}/bin/python")
    assert python.is_file(), f"{python} is missing; './dev consumers' makes it, or name one with CASA_{name.upper()}"
    return python


def packages_of(name: str) -> Path:
    """Its packages, to be put before ours; the variable names the folder of the environment."""
    place = ROOT / os.environ.get(f"CASA_{name.upper()}", f".venv-{name}")
    assert place.is_dir(), f"{place.name} is missing; ./dev consumers makes it"
    (found,) = place.glob("lib/python3*/site-packages")
    return found


def with_packages_of(name: str, **variables: str) -> dict[str, str]:
    """Our environment with its packages before ours."""
    paths = os.pathsep.join([str(packages_of(name)), str(ROOT)])
    return {**os.environ, "PYTHONPATH": paths, "COLUMNS": "200", **variables}


def printed(name: str, script: str, *words: object, timeout_s: float = 300, folder: Path = ROOT) -> str:
    """Output of a script in its environment. script: path from tests/consumers, or whole. folder: to work in."""
    command = [python_of(name), CONSUMERS / script, *words]
    done = subprocess.run(
        list(map(str, command)), cwd=folder, check=False, capture_output=True, text=True, timeout=timeout_s
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


def found_by(name: str, script: str, *words: object, timeout_s: float = 300) -> Any:
    """The JSON in the last line of a script's output there."""
    return json.loads(printed(name, script, *words, timeout_s=timeout_s).splitlines()[-1])


def wait_until(is_so: Callable[[], object], run: subprocess.Popen[str], most_s: float = 300.0) -> None:
    give_up = time.monotonic() + most_s
    while not is_so():
        assert run.poll() is None, f"the run ended before: {run.communicate()}"
        assert time.monotonic() < give_up, "it took too long"
        time.sleep(0.02)


def rows_of(text: str, begin: str = "{") -> list[Any]:
    """The JSON of each line that begins so; other lines are what programs say of themselves."""
    return [json.loads(line) for line in text.splitlines() if line.startswith(begin)]


def build_wheel(project: Path, folder: Path) -> Path:
    """The wheel of a project, put into a folder; its build backend is downloaded where pip has not kept it."""
    _run([sys.executable, "-m", "build", "--wheel", "--outdir", str(folder), str(project)])
    (built,) = folder.glob("*.whl")
    return built


@dataclass(frozen=True)
class Environment:
    """An environment of Python, made by `install`. folder: where it is."""

    folder: Path

    def casa(self, *words: str | Path, cwd: Path, program: str = "casa-assets") -> subprocess.CompletedProcess[str]:
        """Call a program of the environment, where nothing leads to the checkout, a project or a configuration."""
        left_out = [name for name in os.environ if name.startswith(("PYTHON", "CASA_ASSETS_"))]
        kept = {name: value for name, value in os.environ.items() if name not in left_out}
        own = {"XDG_CONFIG_HOME": str(self.folder / "config"), "COLUMNS": "200"}
        variables = {**kept, **own, "CASA_ASSETS_CACHE": os.environ["CASA_ASSETS_CACHE"]}
        command = [str(self.folder / "bin" / program), *map(str, words)]
        return subprocess.run(command, cwd=cwd, env=variables, capture_output=True, text=True, check=False)

    def python(self, script: Path, cwd: Path) -> subprocess.CompletedProcess[str]:
        return self.casa(script, cwd=cwd, program="python")


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
