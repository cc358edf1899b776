"""MuJoCo's own viewer as the command opens it; a stand-in takes the place of the window, which needs a screen."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import mujoco
import mujoco.viewer
import numpy as np
import pytest

from casa_assets.errors import CasaError
from casa_assets.formats.mjcf import document
from casa_assets.layouts.run.load_scene import model_of
from casa_assets.model.asset.behavior import Effect, EffectKind
from casa_assets.show.stills import live_viewer
from casa_assets.show.stills.live_viewer import Glow
from tests.support.asset.family_members import preset

OPEN = 1.0  # rad or m of a door that is well open


class Window:
    """What MuJoCo's handle offers, for some frames; `on_key` gets the code of a key in each."""

    def __init__(self, keys: list[int]) -> None:
        self.opt, self.cam = SimpleNamespace(geomgroup=np.ones(6, dtype=np.uint8)), mujoco.MjvCamera()
        self.keys, self.times, self.on_key = keys, list[float](), lambda _: None
        self.data: Any = None

    def __enter__(self) -> Window:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    lock = staticmethod(nullcontext)

    def is_running(self) -> bool:
        return bool(self.keys)

    def sync(self) -> None:
        self.times.append(float(self.data.time))
        self.on_key(self.keys.pop(0))

    def launch(self, _: Any, data: Any, key_callback: Callable[[int], None], show_left_ui: bool) -> Window:
        assert not show_left_ui
        self.data, self.on_key = data, key_callback
        return self


@pytest.fixture
def model() -> Any:
    return model_of(document.write(preset("microwave", "steel")))


def opened(monkeypatch: pytest.MonkeyPatch, model: Any, keys: list[int], **said: Any) -> Window:
    """The window after as many frames as there are keys."""
    window = Window(keys)
    monkeypatch.setattr(live_viewer, "require_screen", lambda: None)
    monkeypatch.setattr(mujoco.viewer, "launch_passive", window.launch)
    live_viewer.show(model, **said)
    return window


def test_starts_in_the_pose_and_simulates(monkeypatch: pytest.MonkeyPatch, model: Any) -> None:
    window = opened(monkeypatch, model, [0, 0, 0], pose="open")
    assert np.abs(window.data.qpos).max() > OPEN
    assert window.times == sorted(window.times)
    assert window.times[-1] > 0
    assert list(window.opt.geomgroup[:4]) == [1, 1, 1, 0]
    assert window.cam.type == mujoco.mjtCamera.mjCAMERA_FREE
    assert window.cam.distance == pytest.approx(1.5 * model.stat.extent)


def test_space_stops_the_time_and_backspace_goes_back(monkeypatch: pytest.MonkeyPatch, model: Any) -> None:
    space, back = live_viewer.SPACE_KEY, live_viewer.BACKSPACE_KEY
    window = opened(monkeypatch, model, [space, 0, space, back, 0])
    first, second, third, fourth, fifth = window.times
    assert first == second == third < fourth
    assert fifth < fourth + live_viewer.FRAME_S / 2


def test_without_a_window_the_page_is_advised(monkeypatch: pytest.MonkeyPatch, model: Any) -> None:
    monkeypatch.setenv("DISPLAY", ":77")  # there is no such screen, as after a session by ssh that has ended
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(CasaError, match=r"display.*; --web shows a page instead"):
        live_viewer.show(model)


def test_what_acts_glows_until_it_does_no_longer(model: Any) -> None:
    lamp = model.geom("lamp_visual").id
    before = model.geom_matid[lamp], tuple(model.geom_rgba[lamp])
    glow, color = Glow(model), (1.0, 0.9, 0.5, 1.0)
    effect = Effect(variable="lamp", value="on", kind=EffectKind.LIGHT, target="lamp_visual", color=color)
    glow.show({"object": [effect, effect.replace(kind=EffectKind.HEAT, target="int")]})
    assert tuple(model.geom_rgba[lamp]) == pytest.approx(color)
    assert model.geom_matid[lamp] == -1
    glow.show({})
    assert (model.geom_matid[lamp], tuple(model.geom_rgba[lamp])) == before
