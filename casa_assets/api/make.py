"""Make everything that a project describes with one call."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from casa_assets.errors import BatchFault, CasaError
from casa_assets.projects import SETTINGS, project_folder

MISUSE = 2  # exit code of commands: wrong use, or a broken machine
ANSWERS = (0, 1, 4)  # exit codes that say how the work ended; others: that it did not
ERROR = "error:"  # begins the line that tells why a command ended with MISUSE


@dataclass(frozen=True)
class MadeRun:
    """A run of a project, which is a command that has ended.

    Attributes:
        command: such as `casa-assets scenes build --out=out/scenes -- loft__workshop`.
        exit_code: 0: success; 1: something was rejected or failed; 4: a person has to decide something.
        rows: its output with `--json`, a row for each item that it made or kept: `id`, `verdict`, `folder` and more;
            empty for a command without `--json`.
    """

    command: str
    exit_code: int
    rows: tuple[Mapping[str, Any], ...]

    @property
    def passed(self) -> bool:
        """True if nothing was rejected or failed, and a person has nothing to decide."""
        return self.exit_code == 0


def make(project: str | Path | None = None, *, plugins: bool = False) -> tuple[MadeRun, ...]:
    """Run everything that the casa.yaml of a project lists under `runs`, as `casa-assets make` does.

    The commands are run one after the other in separate processes, in the folder of the project. Results of an earlier
    call that are unchanged are kept. Nothing is printed until all have ended.

    Args:
        project: its folder; None: the project in use.
        plugins: run the code in its `plugins/`, which can do whatever you can; a project that is in use with its
            plug-ins runs them in any case.
    Returns:
        Each run, in the order of casa.yaml.
    Raises:
        CasaError: there is no project, a run is wrong (before the first is started), or a command cannot do its work;
            the runs after it are then not made. BatchFault: a bug in the program.
    """
    folder = project_folder() if project is None else Path(project).absolute()
    if folder is None or not (folder / SETTINGS).is_file():
        named = "no project is in use" if project is None else str(project)
        raise CasaError(f"{named}: give a folder with a {SETTINGS}; `casa-assets init` writes one")
    words = [sys.executable, "-m", "casa_assets.cli.main", "make", "--json", "--project", str(folder)]
    done = subprocess.run(
        [*words, *(["--plugins"] if plugins else [])], capture_output=True, text=True, errors="replace", check=False
    )
    runs = tuple(_runs(done.stdout))
    if done.returncode not in ANSWERS:
        name = runs[-1].command if runs and runs[-1].exit_code not in ANSWERS else f"casa-assets make in {folder}"
        told = [line.removeprefix(ERROR).strip() for line in done.stderr.splitlines() if line.startswith(ERROR)]
        if done.returncode == MISUSE:
            raise CasaError(f"{name}: {told[-1] if told else done.stderr.strip()[-1000:]}")
        raise BatchFault([name], done.stderr)
    return runs


def _runs(printed: str) -> Iterator[MadeRun]:
    """Parse the output of `casa-assets make --json`: the rows of each run, then a row about the run itself."""
    rows: list[Mapping[str, Any]] = []
    for line in printed.splitlines():
        try:
            row = json.loads(line)
        except ValueError:
            continue
        if not isinstance(row, dict):
            continue
        if "exit_code" in row:
            yield MadeRun(row["id"], row["exit_code"], tuple(rows))
            rows = []
        else:
            rows.append(row)
