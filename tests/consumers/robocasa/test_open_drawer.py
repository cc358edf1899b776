"""Kitchens in RoboCasa itself: docs/howto/use/robocasa.md and the export's README, by id and drawn at random."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.built_libraries import keep
from tests.documents import blocks
from tests.libraries import casa
from tests.task_objects import task_objects

pytestmark = pytest.mark.consumers
ROOT = Path(__file__).parents[3]
HERE = Path(__file__).parent
PAGE = blocks("docs/howto/use/robocasa.md")
OUT = "out/kitchens"
KITCHENS = ("one_wall_small__rustic", "l_small__coastal")
SEEDS = 10
# What the robosuite on the index lacks, before what a user writes.
SHIMS = f"import sys\nsys.path.insert(0, {str(HERE)!r})\nimport shims\nshims.install()\n"
SAY = "\nimport json\nprint(json.dumps([casa_kitchens.kitchen_of(env), env._check_success(), len(env.objects)]))\n"
# One kitchen is drawn for each seed until all were; its drawer is pulled out by its state.
DRAW = f"""
import json, sys
sys.path.insert(0, FOLDER)
import casa_kitchens, casa_objects, robocasa, robosuite
casa_objects.register()
casa_kitchens.register()
drawn = set()
for seed in range({SEEDS}):
    if len(drawn) == {len(KITCHENS)}:
        break
    env = robosuite.make("OpenDrawer", robots="PandaOmron", layout_and_style_ids=casa_kitchens.layout_and_style_ids(),
                         seed=seed, has_renderer=False, has_offscreen_renderer=False, use_camera_obs=False,
                         obj_registries=("casa",))
    env.reset()
    before = env._check_success()
    env.drawer.open_door(env, min=1.0, max=1.0, partial_open=False)
    env.sim.forward()
    print(json.dumps([casa_kitchens.kitchen_of(env), before, env._check_success()]))
    drawn.add(casa_kitchens.kitchen_of(env))
    env.close()
"""


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the page's own command exports: two kitchens, and objects of the kinds that tasks draw."""
    root = tmp_path_factory.mktemp("robocasa")
    keep(root / "out" / "library", task_objects())
    command, *_ = [line for block in PAGE if block.language == "sh" for line in block.commands]
    program, *arguments = shlex.split(command)
    assert program == "casa-assets"
    done = casa(*(root / word if word.startswith("out/") else word for word in arguments))
    assert done.returncode == 0, done.stderr[-4000:]
    assert set(json.loads((root / OUT / "kitchens.json").read_text(encoding="ascii"))["kitchens"]) == set(KITCHENS)
    return root / OUT


def ran(code: str, place: Path) -> list[list[object]]:
    """What a script prints as JSON, run by the Python that has RoboCasa."""
    python = ROOT / os.environ.get("CASA_ROBOCASA", ".venv-robocasa/bin/python")
    assert python.is_file(), f"{python} is missing; './dev consumers' makes it, or name one with CASA_ROBOCASA"
    script = place / "script.py"
    script.write_text(SHIMS + code, encoding="utf-8")
    done = subprocess.run([str(python), str(script)], check=False, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr[-4000:]
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith('["')]


def in_readme(exported: Path) -> str:
    """The first block of code of the export's README, its folder filled in."""
    lines = (exported / "README.md").read_text(encoding="ascii").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("    "))
    end = next(i for i, line in enumerate(lines) if i > start and not line.startswith("    "))
    assert end - start <= 10
    return textwrap.dedent("\n".join(lines[start:end])).replace("<this folder>", str(exported))


def in_page(exported: Path) -> str:
    """The Python of docs/howto/use/robocasa.md."""
    code, *_ = [block.code for block in PAGE if block.language == "python"]
    return code.replace(f'"{OUT}"', repr(str(exported)))


@pytest.mark.parametrize("code", [in_readme, in_page])
def test_what_is_written_opens_the_kitchen_that_it_names(
    exported: Path, tmp_path: Path, code: Callable[[Path], str]
) -> None:
    [(kitchen, success, objects)] = ran(code(exported) + SAY, tmp_path)
    assert kitchen == min(KITCHENS)
    assert success is False
    assert isinstance(objects, int)
    assert objects > 1


def test_a_drawer_opens_in_kitchens_drawn_at_random(exported: Path, tmp_path: Path) -> None:
    rows = ran(DRAW.replace("FOLDER", repr(str(exported))), tmp_path)
    assert {row[0] for row in rows} == set(KITCHENS)
    assert [row[1:] for row in rows] == [[False, True]] * len(rows)
