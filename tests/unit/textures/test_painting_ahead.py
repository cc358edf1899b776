"""Pictures of a kitchen are painted beside each other, and are what they are when painted one by one."""

from __future__ import annotations

import threading
from functools import partial
from pathlib import Path

import pytest

from casa_assets.core.system import WORKER
from casa_assets.model.registry.rows import Finish
from casa_assets.textures.run.recipes import (
    Painting,
    every_recipe,
    finish_of,
    missing_paintings,
    painted,
    painting_ahead,
)

pytestmark = pytest.mark.content("code", "textures.run", keep=0)

NAMES = ("oak_whitened", "square_white_100", "no_such_finish")
WAIT_S = 20.0


def finish(name: str) -> Finish:
    return Finish.model_construct(id=name)


def test_finishes_are_those_that_are_painted_one_by_one(tmp_path: Path) -> None:
    ahead, alone = tmp_path / "ahead", tmp_path / "alone"
    with painting_ahead(lambda: missing_paintings(NAMES, ahead)):
        found = [finish_of(every_recipe()[name], ahead) for name in NAMES[:2]]
    assert [f.digest for f in found] == [finish_of(every_recipe()[name], alone).digest for name in NAMES[:2]]
    assert missing_paintings(NAMES, ahead) == {}, "they are kept"


def test_two_are_painted_at_once_and_each_once() -> None:
    both, begun = threading.Barrier(2, timeout=WAIT_S), list[str]()

    def painting(name: str) -> Painting:
        def paint() -> Finish:
            begun.append(name)
            both.wait()  # breaks where they come one after the other
            return finish(name)

        return paint

    tasks = {name: painting(name) for name in ("one", "other")}
    with painting_ahead(lambda: tasks):
        assert [painted(name, tasks[name]).id for name in ("one", "other", "one")] == ["one", "other", "one"]
    assert sorted(begun) == ["one", "other"]


def test_what_was_not_foreseen_is_painted_where_it_is_asked_for() -> None:
    with painting_ahead(dict):
        assert painted("late", lambda: finish(str(threading.current_thread() is threading.main_thread()))).id == "True"


def test_what_a_painting_raises_is_raised_where_it_is_asked_for() -> None:
    def fails() -> Finish:
        raise ValueError("no colour")

    with painting_ahead(lambda: {"bad": fails, "good": partial(finish, "good")}):
        assert painted("good", partial(finish, "good")).id == "good"
        with pytest.raises(ValueError, match="no colour"):
            painted("bad", fails)


def never() -> dict[str, Painting]:
    raise AssertionError("what will be needed was looked for")


def test_nothing_is_foreseen_where_nothing_has_to_be_painted() -> None:
    with painting_ahead(never):
        pass


def test_workers_paint_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """There the other cores have workers of their own."""
    monkeypatch.setenv(WORKER, "1")
    with painting_ahead(never):
        assert painted("one", partial(finish, "one")).id == "one"
