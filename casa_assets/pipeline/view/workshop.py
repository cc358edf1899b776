"""Make models in the background, one at a time, and tell how far each is; the last few are kept in memory."""

from __future__ import annotations

import time
import traceback
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock, Thread

from casa_assets.errors import CasaError
from casa_assets.pipeline.view.model import Model, Tell
from casa_assets.pipeline.view.subject import Subject

KEPT = 8  # models in memory; a kitchen takes some tens of megabytes
# A page asks four times a second how far its model is; after so long without, it shows another one or is closed.
ABANDONED_S = 5.0

Maker = Callable[[Subject, Tell], Model]


@dataclass(frozen=True)
class Progress:
    """How far a model is.

    Attributes:
        doing: what is being done, in words. done, of: how much of it; both 0 where that is not known.
        seconds: since it was ordered. error: why there is none; empty where nothing went wrong.
    """

    doing: str = "waiting for another"
    done: int = 0
    of: int = 0
    seconds: float = 0.0
    error: str = ""
    is_ready: bool = False


class _Job:
    """A model that was ordered. Written by the thread that makes it, read by all."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.begin = self.asked = time.monotonic()
        self.progress = Progress()
        self.model: Model | None = None


class Workshop:
    """Models by the id of their subject. Any thread may ask.

    Args:
        make: builds or reads a model; its CasaErrors are told to whoever asks.
    """

    def __init__(self, make: Maker) -> None:
        self._make = make
        self._jobs: OrderedDict[str, _Job] = OrderedDict()
        self._lock, self._bench = Lock(), Lock()

    def order(self, subject: Subject) -> str:
        """Start to make a model unless it is there or on its way; returns its id. What failed is tried again."""
        with self._lock:
            job = self._jobs.get(subject.id)
            if job is None or job.progress.error:
                job = self._jobs[subject.id] = _Job(subject)
                # Ends with the program, whatever it is doing: nothing half-made is left, see Store.
                Thread(target=self._work, args=(job,), daemon=True).start()
            self._jobs.move_to_end(subject.id)
            self._forget_old()
        return subject.id

    def progress(self, model_id: str) -> Progress | None:
        """How far a model is; None where nobody ordered it, or it was forgotten."""
        job = self._find(model_id)
        if job is None:
            return None
        if job.progress.is_ready or job.progress.error:
            return job.progress
        return Progress(job.progress.doing, job.progress.done, job.progress.of, time.monotonic() - job.begin)

    def model(self, model_id: str) -> Model | None:
        """A model that is ready, or None."""
        job = self._find(model_id)
        return None if job is None else job.model

    def subject(self, model_id: str) -> Subject | None:
        """What a model was ordered for, or None."""
        job = self._find(model_id)
        return None if job is None else job.subject

    def _find(self, model_id: str) -> _Job | None:
        """The job of a model, which counts as asked for just now; None where there is none, or it was forgotten."""
        with self._lock:
            job = self._jobs.get(model_id)
            if job is not None:
                job.asked = time.monotonic()
                self._jobs.move_to_end(model_id)
            return job

    def _work(self, job: _Job) -> None:
        def tell(doing: str, done: int, of: int) -> None:
            job.progress = Progress(doing, done, of)

        with self._bench:
            if self._is_abandoned(job):
                return
            try:
                job.model = self._make(job.subject, tell)
            except CasaError as error:
                job.progress = Progress(error=str(error))
            except Exception:  # noqa: BLE001  a thread has nobody above it: the page and the terminal tell of the fault
                traceback.print_exc()
                job.progress = Progress(error="a fault of the program; the terminal shows where")
            else:
                seconds = time.monotonic() - job.begin
                job.progress = Progress("ready", seconds=seconds, is_ready=True)

    def _is_abandoned(self, job: _Job) -> bool:
        """Forget a model that waited for its turn until no page asked for it any more; True where that is so."""
        with self._lock:
            if time.monotonic() - job.asked < ABANDONED_S:
                return False
            if self._jobs.get(job.subject.id) is job:
                del self._jobs[job.subject.id]
            return True

    def _forget_old(self) -> None:
        """Drop models, and what failed, that were asked for longest ago; what is still being made stays."""
        done = [name for name, job in self._jobs.items() if job.model is not None or job.progress.error]
        for name in done[: max(0, len(done) - KEPT)]:
            del self._jobs[name]
