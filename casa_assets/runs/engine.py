"""Run a batch of families, scenes or textures in the worker pool, and report those that fail.

Families, scenes and textures are made from data of the program, not from untrusted files: an error is a fault of the
program, of the machine, or of the user's request, and this module distinguishes these.
"""

from __future__ import annotations

import gc
import logging
import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

from casa_assets import registry
from casa_assets.core.system import cache_dir, cache_for, unusable
from casa_assets.errors import CasaError, OutputError, PluginFailure
from casa_assets.library.library import Library
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.outcome import RunAborted, keep_trace, writing
from casa_assets.runs.pool import Step, Workers, open_engine
from casa_assets.show.stills.renderer import NoRenderer

LOG = logging.getLogger(__name__)
J = TypeVar("J")
T = TypeVar("T")

# Processor seconds after which a job does not end by itself; the slowest known takes three minutes.
CPU_S = 7200.0
# Errors of the machine, which every other item of a batch would meet too.
ABORTS = (OutputError, NoRenderer, MemoryError)


def run_batch(
    function: Callable[[J], T],
    jobs: Sequence[J],
    root: Path,
    workers: Workers,
    warm: Step,
    least_bytes: int,
    goes_on: bool = False,
) -> Iterator[tuple[int, T | WorkerFailure]]:
    """Yield (number of the job, what the function makes of it or a failure) as they finish, each in a worker.

    Args:
        function: of a module, or a partial of one, that answers with something picklable.
        jobs: picklable. root: folder that they write to. workers: where they run.
        warm: see Pool. least_bytes: memory that a job needs.
        goes_on: a job for which the memory does not suffice, tried alone too, is a failure like others.
    Raises:
        CasaError: the disk, the renderer or the memory of this machine does not suffice; what was finished is kept.
    """
    if not jobs:
        return
    if why := unusable(cache_dir()):
        message = "the cache folder %s %s, so %s is used instead; CASA_ASSETS_CACHE names another folder"
        LOG.warning(message, cache_dir(), why, cache_for(root))
    limits = Limits(CPU_S, int(registry.load().limits["input_memory_bytes"]))
    with open_engine(workers, limits, warm, Library(root).private, least_bytes) as pool:
        for number, answer in pool.run(work, [(function, job, root) for job in jobs]):
            if isinstance(answer, RunAborted):
                raise CasaError(answer.message)
            if not goes_on and isinstance(answer, WorkerFailure) and answer.reason in ("memory", "killed"):
                raise CasaError(
                    f"a job was ended for want of memory ({answer.message}); what was finished is kept: run it again "
                    "with less beside it, or with fewer --jobs"
                )
            yield number, answer


def work(task: tuple[Callable[[Any], Any], Any, Path]) -> Any:
    """One job, in a worker."""
    function, job, root = task
    # No record is in a cycle: to look for cycles among so many takes a tenth of a kitchen's time.
    gc.set_threshold(100_000, 20, 20)
    try:
        with writing(root):
            return function(job)
    except (OutputError, NoRenderer) as error:
        return RunAborted(str(error))


def attempt(make: Callable[[], T], failed: Callable[[str, bool], T], root: Path) -> T:
    """Call `make`; where it fails, return what `failed` makes of the failure, so that the other items of a batch go on.

    Args:
        failed: takes a message, and whether the program is to blame: then the message is the trace.
        root: folder that is written to.
    Raises:
        OutputError, NoRenderer, MemoryError: every other item would meet the same.
    """
    try:
        with writing(root):
            return make()
    except ABORTS:
        raise
    except PluginFailure as error:
        return failed(f"{error}; the trace: {keep_trace(error, Library(root))}", False)
    except CasaError as error:
        return failed(str(error), False)
    except Exception:  # noqa: BLE001  the other items go on; the trace is reported and the run ends with exit 3
        return failed(traceback.format_exc(limit=-4), True)
