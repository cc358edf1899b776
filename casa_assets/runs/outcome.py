"""Outcome of one input of a run, the event that reports it, and faults of the disk and of plug-ins."""

from __future__ import annotations

import errno
import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from casa_assets.errors import OutputError, PluginFailure, Rejected
from casa_assets.library.entry_files import Manifest, Summary
from casa_assets.library.library import Library
from casa_assets.model.issue import Decision, Issue, Report, subjects_to_decide
from casa_assets.runs.limits import full_disk

# What is wrong with the disk and not with an input. EFBIG: a quota set with `ulimit -f`.
_DISK_FAULTS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG, errno.EMFILE, errno.ENFILE})
_NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT})
TRACES = "traces"  # folder in the cache of a library
# What verdicts of the pool are called in registry/rejections.yaml, by the reason of a WorkerFailure.
CRASH_CODE = "RUN004"  # of the program, not of the input
FAILURE_CODES = {
    "timeout": "RUN001",
    "memory": "RUN002",
    "signal": "RUN003",
    "killed": "RUN003",
    "error": CRASH_CODE,
    "stuck": "RUN008",
}


@dataclass(frozen=True)
class Outcome:
    """Outcome of the work on one input.

    Attributes:
        accepted: False if rejected; then `code` and `message` say why. warnings: of an accepted one.
        staged: the finished entry in the staging folder, for the parent to publish; None if there is no such entry.
        trace: traceback of a bug in this program; reported once, not kept.
        manifest: of the staged entry of an accepted asset, if it was read already, so that it is not read again.
    """

    accepted: bool
    code: str = ""
    message: str = ""
    warnings: tuple[Issue, ...] = ()
    staged: Path | None = None
    trace: str = ""
    manifest: Manifest | None = None

    @property
    def decision(self) -> Decision:
        """Accepted, in review, or rejected."""
        if not self.accepted:
            return Decision.REJECTED
        return Decision.REVIEW if subjects_to_decide(self.warnings) else Decision.ACCEPTED


@dataclass(frozen=True)
class RunAborted:
    """No input can be worked on, for a reason that has nothing to do with it: the run has to end."""

    message: str


@dataclass(frozen=True)
class Event:
    """The work on one input is done.

    Attributes:
        kind: accepted, review (accepted, and a person has something to decide), rejected, or kept (was there already).
            If an asset is kept because it is better than the result of this run, `message` says why.
        decision: accepted, in review or rejected; also known for kept entries. total: inputs of the run.
        path: of the input. asset_id: its name in the library.
        code: of a rejection. message: of a rejection, or why an accepted asset is kept. warnings: of an accepted one.
        count: number of inputs it covers: rows of a manifest that are only counted are reported in one event.
        folder: of its entry; None for inputs without a separate entry, such as rows of a manifest.
        summary: numbers of an asset, made now or before; None if there is no asset.
    """

    kind: str
    total: int
    path: str
    asset_id: str = ""
    code: str = ""
    message: str = ""
    decision: Decision = Decision.ACCEPTED
    warnings: tuple[Issue, ...] = ()
    count: int = 1
    folder: Path | None = None
    summary: Summary | None = None

    @property
    def was_rejected(self) -> bool:
        """True if no asset was made, now or by an earlier run."""
        return self.decision is Decision.REJECTED

    @property
    def is_in_review(self) -> bool:
        """True if an asset was made and a person has to decide something about it."""
        return self.decision is Decision.REVIEW

    @property
    def reason_kept(self) -> str:
        """Why an accepted asset was kept in place of the result of this run; empty where it was not."""
        return "" if self.was_rejected else self.message

    @property
    def to_decide(self) -> tuple[str, ...]:
        """Subjects that a person has to decide, such as `scale`."""
        return subjects_to_decide(self.warnings)


def first_error(report: Report) -> Rejected:
    """The first error of a report as the reason of a rejection."""
    worst = report.errors[0]
    return Rejected(worst.code, f"{worst.pointer}: {worst.message}" if worst.pointer else worst.message)


@contextmanager
def writing(root: Path) -> Iterator[None]:
    """Turn what the disk of a library, or that for temporary files, refuses into an OutputError; others pass."""
    try:
        yield
    except OSError as error:
        inside = isinstance(error.filename, str | Path) and Path(error.filename).is_relative_to(root)
        if not inside and error.errno not in _DISK_FAULTS:
            raise
        if not inside and error.errno in _NO_ROOM and (full := full_disk()) is not None:
            raise full from error
        raise OutputError(str(root), f"cannot be written to: {error.strerror}") from error


def keep_trace(error: PluginFailure, library: Library) -> Path:
    """Write where code of a plug-in has failed into a file of a library, called after its text; the file."""
    folder = library.cache / TRACES
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{error.plugin}_{hashlib.sha256(error.trace.encode()).hexdigest()[:10]}.txt"
    path.write_text(error.trace, encoding="utf-8")
    return path
