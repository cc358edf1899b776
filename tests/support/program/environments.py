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

from tests.support.library.libraries import ROOT, ran

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
    return ran(python_of(name), CONSUMERS / script, *words, cwd=folder, timeout=timeout_s).stdout


def found_by(name: str, script: str, *words: object, timeout_s: float = 300) -> Any:
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
    ran(sys.executable, "-m", "build", "--wheel", "--outdir", folder, project, timeout=600)
    (built,) = folder.glob("*.whl")
    return built


@dataclass(frozen=True)
class Environment:
    """An environment of Python, made by `install`. folder: where it is."""

    folder: Path

    def casa(
        self, *words: object, cwd: Path, code: int | None = None, program: str = "casa-assets"
    ) -> subprocess.CompletedProcess[str]:
        """Call a program of the environment, where nothing leads to the checkout, a project or a configuration."""
        left_out = [name for name in os.environ if name.startswith(("PYTHON", "CASA_ASSETS_"))]
        kept = {name: value for name, value in os.environ.items() if name not in left_out}
        own = {"XDG_CONFIG_HOME": str(self.folder / "config"), "COLUMNS": "200"}
        variables = {**kept, **own, "CASA_ASSETS_CACHE": os.environ["CASA_ASSETS_CACHE"]}
        return ran(self.folder / "bin" / program, *words, code=code, cwd=cwd, env=variables)

    def python(self, text: str, cwd: Path) -> str:
        """What a script prints that is written into a folder and run there."""
        (cwd / "script.py").write_text(text, encoding="utf-8")
        return self.casa("script.py", cwd=cwd, code=0, program="python").stdout


def install(folder: Path, *wheels: Path) -> Environment:
    """Make an environment with wheels in it. What these depend on comes from the environment that runs the tests."""
    ran(sys.executable, "-m", "venv", "--without-pip", folder, timeout=600)
    pip = (sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "--disable-pip-version-check", "--quiet")
    ran(*pip, "install", "--no-deps", "--no-index", *wheels, timeout=600)
    (site,) = folder.glob("lib/python*/site-packages")
    # A folder that a .pth file names is searched, but .pth files in it are not read: the editable installation of the
    # checkout, which is such a file, stays out.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return Environment(folder)
