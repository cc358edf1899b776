"""The program in this process: no start of another Python and no workers, where nothing about processes is tested."""

from __future__ import annotations

import importlib
import io
import os
import pickle
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any, Self
from unittest.mock import patch

from casa_assets.cli import main
from casa_assets.pipeline.workers import pool
from casa_assets.pipeline.workers.limits import WorkerFailure
from tests.libraries import ROOT


class Here:
    """Runs the jobs of a run one after the other in this process, without limits; see pool.Engine."""

    def __init__(self, *_: Any) -> None:
        pass

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def prepare(self, warm: pool.Step) -> None:
        """Nothing is loaded before the first job asks for it."""

    def run(
        self, function: pool.Step, jobs: Sequence[Any], started: Callable[[int], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """Yield (number of the job, answer or WorkerFailure); jobs and answers are pickled, as between processes."""
        module, name = pool.address_of(function).split(":")
        for number, job in enumerate(jobs):
            if started is not None:
                started(number)
            try:
                answer = getattr(importlib.import_module(module), name)(pickle.loads(pickle.dumps(job)))
            except Exception as error:  # noqa: BLE001  as in a worker
                answer = WorkerFailure("error", f"{type(error).__name__}: {error}", traceback.format_exc())
            yield number, pickle.loads(pickle.dumps(answer))


@contextmanager
def no_workers() -> Iterator[None]:
    """Have runs work in this process."""
    with patch.object(pool, "Pool", Here):
        yield


def called(*arguments: object, folder: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the program in this process, by its own words for errors; as `tests.libraries.casa`, but in seconds less.

    Args:
        folder: to work in. environment: variables for it; all are as they were after it.
    """
    words = [str(word) for word in arguments]
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", "backslashreplace", write_through=True) for _ in range(2))
    with (
        patch.dict(os.environ, {"COLUMNS": "200", **environment}),
        patch.object(sys, "argv", ["casa-assets", *words]),
        no_workers(),
        chdir(folder),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        code = main._run_app()
    told, complained = (stream.buffer.getvalue().decode() for stream in (out, err))  # type: ignore[attr-defined]
    return subprocess.CompletedProcess(words, code, told, complained)
