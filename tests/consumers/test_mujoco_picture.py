"""MuJoCo's own renderer draws the pictures of an asset upright and unmirrored, and hides what collides."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from casa_assets.formats.mjcf import write
from tests.support.asset.assets import textured_box, write_to

# In a process of its own: which OpenGL is used is settled when mujoco is imported.
SCRIPT = """
import json, sys
import mujoco

model = mujoco.MjModel.from_xml_path("scene.xml")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
camera = mujoco.MjvCamera()
camera.lookat[:] = [0, 0, 0.06]
camera.distance, camera.azimuth, camera.elevation = 0.35, 90, 0
with mujoco.Renderer(model, 240, 320) as renderer:
    renderer.update_scene(data, camera)
    picture = renderer.render()
spots = {"top_left": (80, 110), "top_right": (80, 210), "bottom_left": (160, 110), "bottom_right": (160, 210)}
print(json.dumps({name: picture[spot].tolist() for name, spot in spots.items()}))
"""


@pytest.mark.consumers
def test_picture_is_upright(tmp_path: Path) -> None:
    folder = write_to(write(textured_box()), tmp_path)
    environment = {**os.environ, "MUJOCO_GL": os.environ.get("MUJOCO_GL", "egl")}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=folder, env=environment, check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    strongest = {name: max(range(3), key=pixel.__getitem__) for name, pixel in json.loads(done.stdout).items()}
    assert strongest == {"top_left": 0, "top_right": 0, "bottom_left": 1, "bottom_right": 2}
