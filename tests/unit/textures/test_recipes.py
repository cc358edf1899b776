"""Recipes are read with the place of whatever is wrong; finishes come from the store, or are painted side by side."""

from __future__ import annotations

import shutil
import threading
from functools import partial
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.cache.store import Store
from casa_assets.core.system import WORKER
from casa_assets.errors import RegistryError
from casa_assets.model.registry.rows import Finish, Surface
from casa_assets.textures.run.check import check_one, check_recipes, check_sets
from casa_assets.textures.run.recipes import (
    Painting,
    every_recipe,
    find_recipe,
    finish_of,
    missing_paintings,
    painted,
    painting_ahead,
    recipes,
)
from tests.support.program.projects import Project

pytestmark = [pytest.mark.content("code", "textures", keep=0), pytest.mark.content("code", "textures.run", keep=0)]

NAMES = ("oak_whitened", "square_white_100", "no_such_finish")
WAIT_S = 20.0
PLAIN = (
    'one: {kind: plaster, seed: 1, tile_m: [1, 1], substance: stone, params: {color: "#ffffff", second: "#eeeeee"}}\n'
)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A registry with a single wall recipe and empty other sets."""
    target = tmp_path / "registry"
    shutil.copytree(registry.data_root(), target)
    for surface in Surface:
        (target / "textures" / f"{surface.value}.yaml").write_text("{}\n")
    (target / "textures" / "wall.yaml").write_text(PLAIN)
    return target


def test_a_fault_names_its_file_line_and_place_and_an_id_is_used_once_in_all_files(root: Path) -> None:
    for old, new, pointer in (
        ("kind: plaster", "kind: plastic", "one.kind"),
        ("substance: stone", "substance: cheesecloth", "one.substance"),
        ("second:", "third:", "one.params"),
        ('"#eeeeee"', '"grey"', "one.params.second"),
        ("tile_m: [1, 1]", "tile_m: [1, -1]", "one.tile_m"),
        ("seed: 1", "sead: 1", "one"),
    ):
        (root / "textures" / "wall.yaml").write_text("# walls\n\n" + PLAIN.replace(old, new))
        recipes.cache_clear()
        with pytest.raises(RegistryError) as caught:
            recipes(root)
        assert (caught.value.file, caught.value.line) == ("textures/wall.yaml", 3)
        assert caught.value.pointer.startswith(pointer)
    for floors, walls, message in ((PLAIN, PLAIN, "no other surface"), ("{}\n", PLAIN + PLAIN, "each key once")):
        (root / "textures" / "floor.yaml").write_text(floors)
        (root / "textures" / "wall.yaml").write_text(walls)
        recipes.cache_clear()
        with pytest.raises(RegistryError, match=message):
            recipes(root)


def test_a_finish_comes_from_the_store_the_second_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = find_recipe("beadboard_white")
    first = finish_of(wanted, tmp_path, 64)
    monkeypatch.setattr(Store, "put", lambda *_: pytest.fail("painted again"))
    assert finish_of(wanted, tmp_path, 64).digest == first.digest
    assert (first.tile_m, first.substance.id) == (wanted.tile_m, wanted.substance)


def test_a_finish_has_the_substance_that_is_stated_now(tmp_path: Path, project: Project) -> None:
    """Though its picture was painted before."""
    wanted = find_recipe("beadboard_white")
    assert finish_of(wanted, tmp_path / "cache", 64).substance.static_friction < 0.9
    project({"substances.yaml": f"{wanted.substance}: {{static_friction: 0.91}}\n"})
    assert finish_of(wanted, tmp_path / "cache", 64).substance.static_friction == 0.91


def test_recipes_are_checked_one_by_one_and_as_a_set(tmp_path: Path) -> None:
    wanted = [find_recipe("beadboard_white"), find_recipe("tin_ceiling_white")]
    done = list(check_recipes(wanted, tmp_path, jobs=1))
    assert [(c.report.subject, c.report.issues) for c in done] == [(recipe.id, ()) for recipe in wanted]
    assert all(c.report.passed for c in done)
    assert check_sets(done) == ()  # only whole sets are judged
    assert check_one(wanted[0], tmp_path).report == done[0].report


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


def test_what_was_not_foreseen_is_painted_and_what_a_painting_raises_is_raised_where_it_is_asked_for() -> None:
    with painting_ahead(dict):
        assert painted("late", lambda: finish(str(threading.current_thread() is threading.main_thread()))).id == "True"

    def fails() -> Finish:
        raise ValueError("no colour")

    with painting_ahead(lambda: {"bad": fails, "good": partial(finish, "good")}):
        assert painted("good", partial(finish, "good")).id == "good"
        with pytest.raises(ValueError, match="no colour"):
            painted("bad", fails)


def test_nothing_is_foreseen_where_nothing_has_to_be_painted_and_workers_paint_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Other workers use the other cores."""

    def never() -> dict[str, Painting]:
        raise AssertionError("what will be needed was looked for")

    with painting_ahead(never):
        pass
    monkeypatch.setenv(WORKER, "1")
    with painting_ahead(never):
        assert painted("one", partial(finish, "one")).id == "one"
