"""Completion of names in the shell: it gives the names that the registry gives, and imports nothing heavy for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from casa_assets import registry
from casa_assets.cli import completion
from casa_assets.model.kitchen.choices import Surface
from casa_assets.registry.families import family, family_names, object_names
from casa_assets.registry.kitchens import plan_names, style_names
from casa_assets.registry.tables import robot_names
from casa_assets.textures.run.check import select_recipes


def context(**params: Any) -> Any:
    return SimpleNamespace(params=params, args=[])


def test_names_are_those_of_the_registry() -> None:
    assert completion.plans("") == list(plan_names())
    assert completion.styles("") == list(style_names())
    assert completion.families("") == sorted(family_names())
    assert completion.categories("") == sorted(registry.load().categories)
    assert completion.objects("") == sorted(object_names())
    assert completion.robots("") == sorted(robot_names())


def test_textures_are_those_that_verbs_take() -> None:
    names = completion.textures("")
    assert {recipe.id for recipe in select_recipes([], list(Surface))} <= set(names)
    assert [recipe.id for recipe in select_recipes(names, [])] == names


def test_presets_are_those_of_the_family() -> None:
    for name in family_names():
        assert completion.presets(context(names=[name]), "") == sorted(family(name).presets)
    assert completion.presets(context(names=["microwave"]), "ste") == ["steel"]


def test_kitchens_are_every_plan_in_every_style_and_what_is_built(tmp_path: Path) -> None:
    built = tmp_path / "galley__rustic__s7__t5c1d2e3f"
    built.mkdir()
    (built / "scene.json").write_text("{}", encoding="utf-8")
    names = completion.kitchens(context(out=tmp_path), "galley__r")
    assert names == ["galley__rustic", built.name]
    assert len(completion.kitchens(context(out=tmp_path / "none"), "")) == len(plan_names()) * len(style_names())


def test_assets_are_those_of_the_libraries_in_their_usual_places(tmp_path: Path, monkeypatch: Any) -> None:
    folder = tmp_path / "out" / "library" / "mug" / "mug_0a1b2c3d4e"
    folder.mkdir(parents=True)
    (folder / "asset.json").write_text("{}", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert completion.assets("out/library/mug/m") == [f"out/library/mug/{folder.name}{end}" for end in ("", "/")]


def test_of_many_assets_the_categories_are_offered_first(tmp_path: Path, monkeypatch: Any) -> None:
    for category in ("bowl", "mug"):
        for number in range(completion.MOST_ASSETS):
            (tmp_path / "out" / "library" / category / f"{category}_{number:010x}").mkdir(parents=True)
    (tmp_path / "out" / "library" / "rejected" / "unknown_0").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    assert {"out/library/bowl/", "out/library/mug/"} <= set(completion.assets("out/library/"))
    assert len(completion.assets("out/library/")) < 10
    assert "out/library/mug/mug_0000000007" in completion.assets("out/library/mug/")


def complete(*words: str) -> list[str]:
    """What a shell is offered behind some words, the last of which is begun."""
    environment = {
        **os.environ,
        "_CASA_ASSETS_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(["casa-assets", *words]),
        "COMP_CWORD": str(len(words)),
    }
    code = "import sys; sys.argv = ['casa-assets']; from casa_assets.cli.main import app; app(prog_name='casa-assets')"
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    return done.stdout.split()


def test_a_shell_is_offered_names() -> None:
    assert "l_small__coastal" in complete("scenes", "build", "l_small__c")
    assert complete("scenes", "new", "gal") == ["galley"]
    assert complete("scenes", "new", "galley", "--style", "rust") == ["rustic"]
    assert complete("families", "show", "microwave", "--preset", "ste") == ["steel"]
    assert "apple" in complete("objects", "build", "app")
    assert complete("categories", "show", "mug") == ["mug"]
    assert complete("textures", "make", "brick_red_r") == ["brick_red_running"]
    assert "mug" in complete("ingest", "x.obj", "--category", "mug")


def test_completion_imports_nothing_heavy() -> None:
    code = (
        "import sys; from casa_assets.cli import completion as c; c.categories('m'); c.textures('o'); c.plans('');"
        "print(sorted({'numpy', 'pydantic', 'yaml', 'scipy', 'mujoco', 'casa_assets.registry'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
