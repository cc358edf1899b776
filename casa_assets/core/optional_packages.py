"""Optional dependencies: which packages an extra needs, and the command that installs it on this machine."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import re
import shlex
import sys
import tomllib
from pathlib import Path
from typing import Any

from casa_assets.errors import CasaError

DISTRIBUTION = "casa-assets"
FOR_DEVELOPERS = "dev"
_CHECKOUT = Path(__file__).parents[2]
_EXTRA = re.compile(r""";.*\bextra\s*==\s*["']([\w.-]+)["']""")  # as metadata name the extra of a requirement


def requirements() -> tuple[str, ...]:
    """Requirements of this package without extras, such as "numpy>=2.1"."""
    project = _project()
    if project is not None:
        return tuple(project["dependencies"])
    return tuple(line for line in importlib.metadata.requires(DISTRIBUTION) or [] if not _EXTRA.search(line))


def extras() -> dict[str, tuple[str, ...]]:
    """Name of each extra for users -> what it requires, such as {"parquet": ("pyarrow>=17",)}; sorted."""
    project = _project()
    found: dict[str, tuple[str, ...]] = {}
    if project is not None:
        found = {name: tuple(lines) for name, lines in project["optional-dependencies"].items()}
    else:
        for line in importlib.metadata.requires(DISTRIBUTION) or []:
            if named := _EXTRA.search(line):
                found[named[1]] = (*found.get(named[1], ()), line.partition(";")[0].strip())
    return {name: found[name] for name in sorted(found) if name != FOR_DEVELOPERS}


def install_command(extra: str) -> str:
    """Command that installs an extra into this environment.

    The package is on no index. In a checkout the checkout is installed with the extra and the pinned versions;
    elsewhere the packages that the extra requires are installed by their own names.
    """
    pip = f"{shlex.quote(sys.executable)} -m pip install"
    if _project() is None:
        return f"{pip} {shlex.join(extras()[extra])}"
    return f"{pip} -c {shlex.quote(str(_CHECKOUT / 'constraints.txt'))} -e {shlex.quote(f'{_CHECKOUT}[{extra}]')}"


def require(module: str, extra: str, purpose: str) -> None:
    """Check that an optional module is installed, without importing it.

    Args:
        module: name of a module on the top level.
        extra: the extra that brings it.
        purpose: what needs it, as the beginning of a sentence.
    Raises:
        CasaError: it is not installed; names the extra and the command.
    """
    if importlib.util.find_spec(module) is None:
        message = f"{purpose} needs {module}, which is not installed; the extra '{extra}' brings it"
        raise CasaError(f"{message}: {install_command(extra)}")


def _project() -> dict[str, Any] | None:
    """The table `project` of pyproject.toml; None away from a checkout."""
    path = _CHECKOUT / "pyproject.toml"
    if not path.is_file():
        return None
    project: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8")).get("project", {})
    return project if project.get("name") == DISTRIBUTION else None
