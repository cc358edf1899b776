"""Path-traced stills as far as no path tracer is needed: where the camera is, faults of pictures, no Blender."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from casa_assets.cli.main import app
from casa_assets.core import system
from casa_assets.errors import UnknownId
from casa_assets.show.reports import pictures
from casa_assets.show.stills import photoreal
from casa_assets.show.stills.photoreal import BEYOND_M, NoPathTracer, eye_view, scene_stills

WIDE = 16 / 9
OVERVIEW = {"name": "overview", "fov_y_deg": 50.0, "position": [2.0, -9.0, 6.0], "quaternion": [0.86, 0.5, 0.0, 0.0]}


def fixture(role: str, position: tuple[float, float, float], size: tuple[float, float, float]) -> dict[str, Any]:
    """One that faces -y."""
    region = {"position": position, "size": size}
    return {"role": role, "quaternion": [1.0, 0.0, 0.0, 0.0], "regions": {"main": region}}


def room(*fixtures: dict[str, Any], deep: float = 4.0) -> dict[str, Any]:
    """A scene.json of a room 4 m wide, its front open, its back at y = 0."""
    corners = [[0.0, 0.0], [4.0, 0.0], [4.0, -deep], [0.0, -deep]]
    ends = zip(corners, [*corners[1:], corners[0]], strict=True)
    walls = [{"id": str(k), "from": [*a, 0.0], "to": [*b, 0.0], "open": k == 2} for k, (a, b) in enumerate(ends)]
    shell = {"outline": corners, "bounds": [[0, -deep, 0], [4, 0, 2.7]], "walls": walls, "openings": []}
    return {"room": shell, "cameras": [OVERVIEW], "fixtures": list(fixtures)}


RANGE = fixture("range", (2.0, -0.3, 0.45), (0.8, 0.6, 0.9))
FRIDGE = fixture("fridge", (0.5, -0.4, 0.9), (0.9, 0.7, 1.8))


def test_the_eye_looks_level_at_things_on_the_wall() -> None:
    view = eye_view(room(RANGE, FRIDGE), "eye", WIDE)
    w, x, y, z = view.quaternion
    ahead = -np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    assert view.position[2] == photoreal.EYE_M
    assert ahead[2] == pytest.approx(0.0, abs=1e-9)
    for target in ((2.0, -0.3), (0.5, -0.4)):
        offset = np.array(target) - view.position[:2]
        assert math.acos(offset @ ahead[:2] / np.linalg.norm(offset)) < view.fov_x / 2


def test_the_eye_is_where_there_is_room_or_beyond_an_open_side_of_a_shallow_room() -> None:
    island = fixture("island", (2.0, -2.2, 0.45), (2.0, 0.9, 0.9))
    x, y, _ = eye_view(room(RANGE, FRIDGE, island), "eye", WIDE).position
    assert -4.0 < y < 0.0
    assert 0.0 < x < 4.0
    assert not (0.9 < x < 3.1 and -2.8 < y < -1.6)
    _, y, _ = eye_view(room(RANGE, FRIDGE, deep=1.6), "eye", WIDE, BEYOND_M).position
    assert -1.6 - BEYOND_M < y < -1.6
    _, y, _ = eye_view(room(RANGE, FRIDGE, deep=1.6), "eye", WIDE).position
    assert y > -1.6


def test_the_sun_comes_in_and_down_through_a_window_past_things_beside_it() -> None:
    view = eye_view(room(RANGE, FRIDGE), "eye", WIDE)
    for second, is_turned in ((FRIDGE, False), (fixture("housing", (2.9, -0.8, 1.3), (0.1, 1.6, 2.6)), True)):
        scene = room(RANGE, second)
        window = {"id": "w", "kind": "window", "wall": "0", "from": [1.4, 0.0, 1.0], "to": [2.6, 0.0, 2.0]}
        scene["room"]["openings"] = [window]
        sun = photoreal.sun_direction(scene, view, WIDE)
        assert np.linalg.norm(sun) == pytest.approx(1.0)
        assert max(sun[1:]) < 0
        assert sun[0] < 0 or not is_turned


@pytest.fixture
def kitchen(tmp_path: Path) -> Path:
    folder = tmp_path / "l_small__coastal"
    folder.mkdir()
    (folder / "scene.usda").write_text("#usda 1.0\n", encoding="utf-8")
    (folder / "scene.json").write_text(json.dumps(room(RANGE, FRIDGE)), encoding="utf-8")
    keys = "<keyframe><key name='start'/><key name='open'/></keyframe>"
    (folder / "scene.xml").write_text(f"<mujoco>{keys}</mujoco>", encoding="utf-8")
    return folder


def test_a_machine_without_blender_is_advised(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kitchen: Path) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv(system.BLENDER_VARIABLE, raising=False)
    monkeypatch.setattr(system, "_CHECKOUT", tmp_path / "none")
    with pytest.raises(NoPathTracer, match="pip install bpy==5"):
        next(scene_stills(kitchen))


def test_what_cannot_be_drawn_is_refused(kitchen: Path, tmp_path: Path) -> None:
    with pytest.raises(UnknownId, match=r"scene.xml 'opne'; did you mean open\?"):
        list(pictures.draw_stills([kitchen], tmp_path / "out", photoreal.StillSettings(), "opne"))
    with pytest.raises(NoPathTracer, match="no camera 'nowhere'; there are eye, cutaway, overview"):
        next(scene_stills(kitchen, ["nowhere"]))
    assert CliRunner().invoke(app, ["preview", str(kitchen), "--photoreal", "--colliders"]).exit_code == 2
