"""Validate USD files by SimReady, in this process or, one process for each file, by another Python."""

from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from casa_assets.checks.simready import rules
from casa_assets.checks.simready.installed import NoVerdict, run_child, validator_python
from casa_assets.checks.simready.rules import Verdict

NO_VERDICT = "the validator of SimReady gave no verdict"
CHILD_LIMIT_S = 600.0  # a large kitchen takes seconds
# Names of folders, and lengths of paths, that no rule of SimReady refuses; its own limit is 260 characters.
_PLAIN = re.compile(r"(?!(?:CON|PRN|AUX|NUL|COM[1-9]|LPT[1-9])$)[A-Z0-9._-]+", re.IGNORECASE)
_LONGEST = 200


def validate_simready(path: Path, folder: Path, without: frozenset[str] = frozenset()) -> Verdict:
    """Validate a USD file as SimReady's command line does, wherever it lies.

    Args:
        path: of the root layer. folder: of its asset or scene. Names of folders above it, and how long their path is,
            have no part in the verdict.
        without: codes of requirements that need not be run, since the caller does not count them.
    Returns:
        Whether it passes, and code -> message of each requirement that the profile demands and that is not met.
    Raises:
        NoVerdict: the validator is not installed, or it failed.
    """
    python = validator_python()
    with _at_plain_path(path.absolute(), folder.absolute()) as seen:
        found = _by_child(python, seen, without) if python else _here(seen, without)
    if found is None:
        raise NoVerdict(NO_VERDICT)
    return found


def load_rules() -> None:
    """Load what validates, where that is done in this process, so that processes forked from it need not."""
    try:
        if not validator_python():
            rules.load_rules()
    except (NoVerdict, ImportError):
        return


@contextmanager
def _at_plain_path(path: Path, folder: Path) -> Iterator[Path]:
    """The same file by a path of which only `folder` and what is below it can break a rule on names or lengths."""
    above = folder.parent
    lengths = len(str(path)), len(os.path.relpath(path))
    if max(lengths) <= _LONGEST and all(_PLAIN.fullmatch(name) for name in above.parts[1:]):
        yield path
        return
    place = "/tmp" if os.access("/tmp", os.W_OK) else None  # noqa: S108  the user's own may have any name
    with tempfile.TemporaryDirectory(prefix="casa_simready_", dir=place) as root:
        link = Path(root, "above")
        link.symlink_to(above, target_is_directory=True)
        yield link / path.relative_to(above)


def _here(path: Path, without: frozenset[str]) -> Verdict | None:
    try:
        return rules.validate(path, without)
    except ImportError as error:
        raise NoVerdict(f"SimReady's validator cannot be imported: {error}", is_missing=True) from error


def _by_child(python: str, path: Path, without: frozenset[str]) -> Verdict | None:
    try:
        done = run_child(python, [str(path), *sorted(without)], CHILD_LIMIT_S)
    except subprocess.TimeoutExpired:
        raise NoVerdict(f"the validator of SimReady did not end within {CHILD_LIMIT_S:g} s") from None
    except OSError as error:
        raise NoVerdict(f"the validator of SimReady cannot be started: {error}", is_missing=True) from error
    try:
        answer = json.loads(done.stdout) if done.returncode == 0 else None
    except ValueError:
        answer = None
    if answer is None:
        words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:] or ["it said nothing"]
        raise NoVerdict(f"the validator of SimReady ended with {done.returncode}: {words[0][:200]}")
    if "missing" in answer:
        raise NoVerdict(f"SimReady's validator cannot be imported: {answer['missing']}", is_missing=True)
    verdict = answer["verdict"]
    return None if verdict is None else (bool(verdict[0]), dict(verdict[1]))
