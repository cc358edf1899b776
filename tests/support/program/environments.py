"""Environments of other programs, which `./dev consumers` makes: `.venv-<name>`, or what CASA_<NAME> names."""

from __future__ import annotations

import json
import os
import subprocess
import time
from collections.abc import Callable
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
    """Wait until something is so, as long as a run is going on."""
    give_up = time.monotonic() + most_s
    while not is_so():
        assert run.poll() is None, f"the run ended before: {run.communicate()}"
        assert time.monotonic() < give_up, "it took too long"
        time.sleep(0.02)


def rows_of(text: str, begin: str = "{") -> list[Any]:
    """The JSON of each line that begins so; other lines are what programs say of themselves."""
    return [json.loads(line) for line in text.splitlines() if line.startswith(begin)]
