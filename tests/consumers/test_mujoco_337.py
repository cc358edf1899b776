"""What we write loads without a word in the oldest MuJoCo that we support, and means the same there."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import mujoco
import pytest

from casa_assets.export.mjcf import write
from casa_assets.export.mjcf.scene import kitchen
from casa_assets.model.asset.asset import Asset, Base
from tests.assets import EVERY, microwave, write_to
from tests.scenes import Weight, corner, expected, in_form, put

ROOT = Path(__file__).parents[2]
PYTHON = ROOT / os.environ.get("CASA_MUJOCO337", ".venv-mujoco337/bin/python")

# Runs there: needs mujoco alone.
SCRIPT = """
import json, sys, warnings
import mujoco

said = []
mujoco.set_mju_user_warning(said.append)
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    model = mujoco.MjModel.from_xml_path(sys.argv[1])
    data = mujoco.MjData(model)
    for _ in range(1000):
        mujoco.mj_step(model, data)
troubles = sum(w.number for w in data.warning)
names = [model.body(i).name for i in range(1, model.nbody)]
print(json.dumps({
    "version": mujoco.__version__,
    "warnings": said + [str(w.message) for w in caught],
    "troubles": int(troubles),
    "masses": {name: float(m) for name, m in zip(names, model.body_mass[1:]) if name},
    "height": float(data.body("object").xpos[2]),
}))
"""


# A scene is not stepped: things hang in the air there.
SCENE = """
import json, sys, warnings
import mujoco

said = []
mujoco.set_mju_user_warning(said.append)
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    model = mujoco.MjModel.from_xml_path(sys.argv[1])
print(json.dumps({
    "version": mujoco.__version__,
    "warnings": said + [str(w.message) for w in caught],
    "bodies": [model.body(i).name for i in range(1, model.nbody)],
    "keys": [model.key(i).name for i in range(model.nkey)],
    "lights": [int(kind) for kind in model.light_type],
}))
"""


def free_microwave() -> Asset:
    return microwave(Base.FREE)


@pytest.mark.consumers
def test_the_old_interpreter_is_there() -> None:
    assert PYTHON.is_file(), f"{PYTHON} is missing; './dev consumers' makes it, or name one with CASA_MUJOCO337"


@pytest.mark.consumers
@pytest.mark.parametrize("build", [*EVERY, free_microwave])
@pytest.mark.parametrize("file", ["model.xml", "scene.xml"])
def test_loads_in_silence_and_stands(build: Callable[[], Asset], file: str, tmp_path: Path) -> None:
    asset = build()
    folder = write_to(write(asset), tmp_path)
    done = subprocess.run(
        [str(PYTHON), "-c", SCRIPT, file], cwd=folder, check=False, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    found = json.loads(done.stdout)
    assert found["version"].startswith("3.3.")
    assert found["warnings"] == []
    assert found["troubles"] == 0
    assert found["masses"] == pytest.approx({link.name: link.inertial.mass for link in asset.links})
    assert found["height"] == pytest.approx(0.0, abs=1e-3)
    assert not (folder / "MUJOCO_LOG.TXT").exists()


@pytest.mark.consumers
@pytest.mark.parametrize("weight", list(Weight))
def test_a_whole_scene_loads_in_silence(weight: Weight, tmp_path: Path) -> None:
    folder = put(kitchen.write(in_form(corner(), weight)), tmp_path, corner())
    done = subprocess.run(
        [str(PYTHON), "-c", SCENE, "scene.xml"], cwd=folder, check=False, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    found = json.loads(done.stdout)
    assert found["version"].startswith("3.3.")
    assert found["warnings"] == []
    bodies = expected(corner(), "closed")
    if weight is Weight.LIGHT:  # what is fixed may be merged into what it is fixed to, what moves may not
        here = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
        assert sorted(found["bodies"]) == sorted(here.body(i).name for i in range(1, here.nbody))
        full = mujoco.MjModel.from_xml_path(
            str(put(kitchen.write(corner()), tmp_path / "full", corner()) / "scene.xml")
        )
        moving = {name for name in bodies if full.body(name).jntnum[0]}
        assert moving
        assert moving <= set(found["bodies"]) < set(bodies)
    else:
        assert sorted(found["bodies"]) == sorted(bodies)
    assert found["keys"] == ["start", "closed", "open"]
    assert found["lights"] == [1, 2, 0]
