"""Kitchens in RoboCasa itself: docs/howto/use/robocasa.md as it is written, the export's README, and any kitchen."""

from __future__ import annotations

import json
import shutil
import textwrap
from pathlib import Path

import pytest

from tests.support.program.documents import blocks, shell
from tests.support.program.environments import printed, rows_of

pytestmark = pytest.mark.consumers
PAGE = blocks("docs/howto/use/robocasa.md")
OUT = "out/kitchens"
KITCHENS = ("one_wall_small__rustic", "l_small__coastal")
# After what is written: where it is, and that robosuite is patched once.
SAY = """
import json
assert casa_kitchens.patch_robosuite() == ()
print(json.dumps([casa_kitchens.kitchen_of(env), env._check_success(), len(env.objects)]))
"""
# One kitchen is drawn for each seed until all were; its drawer is pulled out by its state.
DRAW = f"""
import json, sys
sys.path.insert(0, "{OUT}")
import casa_kitchens, casa_objects, robocasa, robosuite
casa_kitchens.patch_robosuite()
casa_objects.register()
casa_kitchens.register()
drawn = set()
for seed in range(10):
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
def place(tmp_path_factory: pytest.TempPathFactory, samples: Path) -> Path:
    """A folder with the library of README.md, after the first commands of the page: two kitchens, and objects."""
    root = tmp_path_factory.mktemp("robocasa") / "place"
    shutil.copytree(samples, root)
    for command in next(block for block in PAGE if block.language == "sh").commands:
        done = shell(command, root)
        assert done.returncode == 0, done.stderr[-4000:]
    index = json.loads((root / OUT / "kitchens.json").read_text(encoding="ascii"))
    assert set(index["kitchens"]) == set(KITCHENS)
    return root


def ran(code: str, place: Path) -> list[list[object]]:
    """What a script prints as JSON, run in that folder by the Python that has RoboCasa."""
    (place / "script.py").write_text(code, encoding="utf-8")
    return rows_of(printed("robocasa", str(place / "script.py"), timeout_s=900, folder=place), '["')


def in_readme(place: Path) -> str:
    """The first block of code of the export's README, its folder filled in."""
    lines = (place / OUT / "README.md").read_text(encoding="ascii").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("    "))
    end = next(i for i, line in enumerate(lines) if i > start and not line.startswith("    "))
    assert end - start <= 10
    return textwrap.dedent("\n".join(lines[start:end])).replace("<this folder>", str(place / OUT))


@pytest.mark.parametrize("source", ["README", "page"])
def test_what_is_written_opens_the_kitchen_that_it_names(place: Path, source: str) -> None:
    code = in_readme(place) if source == "README" else next(b.code for b in PAGE if b.language == "python")
    [(kitchen, success, objects)] = ran(code + SAY, place)
    assert kitchen == min(KITCHENS)
    assert success is False
    assert int(str(objects)) > 1


def test_a_drawer_opens_in_kitchens_drawn_at_random(place: Path) -> None:
    rows = ran(DRAW, place)
    assert {row[0] for row in rows} == set(KITCHENS)
    assert [row[1:] for row in rows] == [[False, True]] * len(rows)
