"""Find a Python that has SimReady's validator: this one, or another one.

The validator is optional (the extra `simready`) and has no release for Python 3.13 or newer.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from functools import cache
from importlib.metadata import distributions
from pathlib import Path

from casa_assets.projects import user_environment

EXTRA = "simready"
# Names a Python that has the validator; it is used even where this one has it too.
VARIABLE = "CASA_SIMREADY_PYTHON"
NEWEST_PYTHON = (3, 12)  # simready-foundation-tier-core stops there
NEEDED = ("simready-validate", "simready-foundation-tier-core")
# Packages that decide a verdict.
DECIDING = (*NEEDED, "usd-validation-nvidia", "usd-core")
# Prints {name: version} of the packages that are its arguments, as far as they are installed.
_PROBE = (
    "import importlib.metadata as m, json, sys\n"
    "print(json.dumps({n: d.version for n in sys.argv[1:] for d in list(m.distributions(name=n))[:1]}))"
)
_PROBE_LIMIT_S = 60.0
_CHECKOUT = Path(__file__).parents[2]
_PYTHON = Path("bin", "python")


class NoVerdict(Exception):
    """A file was not validated; the text is a part of a sentence that says why.

    Attributes:
        is_missing: the validator is not installed, which is nobody's fault; else it failed on this file.
    """

    def __init__(self, reason: str, is_missing: bool = False) -> None:
        super().__init__(reason)
        self.is_missing = is_missing


def validator_python() -> str:
    """Path of another Python that has the validator; empty where this one is used. Raises NoVerdict: neither has it."""
    named = os.environ.get(VARIABLE, "")
    if named:
        if not _has_validator(_versions_in(named)):
            raise NoVerdict(f"{VARIABLE} names '{named}', a Python without SimReady's validator", is_missing=True)
        return named
    if _has_validator(_versions_here()):
        return ""
    for place in (_CHECKOUT / ".venv-simready", user_environment(EXTRA)):
        python = str(place / _PYTHON)
        if _has_validator(_versions_in(python)):
            return python
    if sys.version_info[:2] > NEWEST_PYTHON:
        advice = " and needs Python 3.11 or 3.12: see `casa-assets doctor`"
    else:
        advice = f": pip install 'casa-assets[{EXTRA}]'"
    raise NoVerdict(f"SimReady's validator is not installed{advice}", is_missing=True)


def validator_versions() -> dict[str, str]:
    """Versions of the packages that decide a verdict, by name; empty if no validator is installed."""
    try:
        python = validator_python()
    except NoVerdict:
        return {}
    return dict(_versions_in(python) if python else _versions_here())


def versions_elsewhere() -> dict[str, str]:
    """The same of another Python, without its usd-core; empty where this Python validates."""
    if _has_validator(_versions_here()) and not os.environ.get(VARIABLE):
        return {}
    return {name: number for name, number in validator_versions().items() if name != "usd-core"}


def how_to_install() -> str:
    """Command that makes an environment for the validator where this Python is too new for it."""
    if (_CHECKOUT / "dev").is_file():
        return "./dev setup  # needs a Python 3.11 or 3.12, such as PYTHON=python3.12"
    place = shlex.quote(str(user_environment(EXTRA)))
    return f"python3.12 -m venv {place} && {place}/bin/pip install numpy 'usd-core<26' {' '.join(NEEDED)}"


def _has_validator(versions: dict[str, str]) -> bool:
    return all(name in versions for name in NEEDED)


@cache
def _versions_here() -> dict[str, str]:
    return {name: found.version for name in DECIDING for found in list(distributions(name=name))[:1]}


@cache
def _versions_in(python: str) -> dict[str, str]:
    """The same of another Python; empty where it does not run."""
    if not os.access(python, os.X_OK):
        return {}
    try:
        done = run_program(python, _PROBE, DECIDING, _PROBE_LIMIT_S)
        return dict(json.loads(done.stdout)) if done.returncode == 0 else {}
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return {}


def run_program(
    python: str, program: str, arguments: tuple[str, ...], limit_s: float
) -> subprocess.CompletedProcess[bytes]:
    """Run the text of a program by another Python. Raises OSError, subprocess.TimeoutExpired."""
    command = [python, "-I", "-c", program, *arguments]
    return subprocess.run(command, capture_output=True, timeout=limit_s, check=False)
