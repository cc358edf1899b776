"""Models that nobody waits for any more are not begun, and what failed does not pile up."""

from __future__ import annotations

import time
from pathlib import Path
from threading import Event

import pytest

from casa_assets.errors import CasaError
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.show.view import server as subject
from casa_assets.show.view.model import Model, ShowProgress
from casa_assets.show.view.server import KEPT, Workshop
from casa_assets.show.view.subject import Kitchen, Subject

PATIENCE_S = 10.0


def kitchen(seed: int) -> Kitchen:
    return Kitchen(SceneRecipe("galley", "coastal", seed), Path())


def wait_until_over(workshop: Workshop, model_id: str) -> None:
    """Until a model is ready, has failed, or is forgotten; without asking for it, which would keep it."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        job = workshop._jobs.get(model_id)
        if job is None or job.model is not None or job.progress.error:
            return
        time.sleep(0.01)
    raise AssertionError(f"{model_id} is not done")


def test_what_waited_until_no_page_asked_for_it_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subject, "ABANDONED_S", 0.2)
    made: list[str] = []
    is_begun, may_end = Event(), Event()

    def make(wanted: Subject, tell: ShowProgress) -> Model:
        made.append(wanted.id)
        is_begun.set()
        assert may_end.wait(PATIENCE_S)
        return Model(wanted.id, b"", {}, {}, None)

    workshop = Workshop(make)
    first, left, wanted = (workshop.order(kitchen(seed)) for seed in range(3))
    assert is_begun.wait(PATIENCE_S)
    for _ in range(4):
        time.sleep(0.1)
        assert workshop.progress(wanted) is not None
    may_end.set()
    for name in (first, left, wanted):
        wait_until_over(workshop, name)
    assert made == [first, wanted]
    assert workshop.progress(left) is None
    assert workshop.model(wanted) is not None


def test_what_failed_is_forgotten_like_the_others() -> None:
    def fail(_: Subject, tell: ShowProgress) -> Model:
        raise CasaError("there is no wood")

    workshop = Workshop(fail)
    names = []
    for seed in range(KEPT + 3):
        names.append(workshop.order(kitchen(seed)))
        wait_until_over(workshop, names[-1])
    workshop.order(kitchen(99))
    assert workshop.progress(names[0]) is None
    assert workshop.progress(names[-1]) is not None
