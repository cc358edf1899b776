"""Show a compiled model in MuJoCo's own viewer, on a screen, simulated in real time, and colour what acts in it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import glfw
import mujoco
import mujoco.viewer
import numpy as np

from casa_assets.errors import CasaError
from casa_assets.model.asset.behavior import Effect, EffectKind
from casa_assets.show.stills.still import set_keyframe

FRAME_S = 1 / 60
# Simulated seconds that one frame catches up at most: a machine that is too slow shows slow motion and stays usable.
MAX_CATCH_UP_S = 0.05
SPACE_KEY, BACKSPACE_KEY = 32, 259  # GLFW's codes
# Called once a frame with the model and its data, before the frame is shown.
EachFrame = Callable[[Any, Any], None]
# Targets of effects of these kinds change their look; heat, cold and turning are not seen in a still picture.
SEEN = frozenset({EffectKind.SHOW, EffectKind.LIGHT})


def show(model: Any, pose: str = "", name: str = "the model", each_frame: EachFrame | None = None) -> None:
    """Open the viewer and return when its window is closed. Space stops the time, Backspace goes back to the pose.

    It starts in the keyframe `pose`, or as the model does; `each_frame` may change colours, to show what is on.

    Raises:
        CannotDraw: it has no such keyframe. CasaError: no window can be opened.
    """
    require_screen()
    data = mujoco.MjData(model)

    def start() -> None:
        if pose:
            set_keyframe(model, data, pose, name)
        else:
            mujoco.mj_resetData(model, data)
        mujoco.mj_forward(model, data)

    start()
    running, wanted = [True], [False]

    def on_key(code: int) -> None:
        if code == SPACE_KEY:
            running[0] = not running[0]
        elif code == BACKSPACE_KEY:
            wanted[0] = True

    with mujoco.viewer.launch_passive(model, data, key_callback=on_key, show_left_ui=False) as handle:
        with handle.lock():
            handle.opt.geomgroup[:] = shown_groups(model)
            mujoco.mjv_defaultFreeCamera(model, handle.cam)
        while handle.is_running():
            begin = time.perf_counter()
            with handle.lock():
                if wanted[0]:
                    start()
                    wanted[0] = False
                end = data.time + FRAME_S  # one frame, or as much of it as the machine manages in that time
                while running[0] and data.time < end and time.perf_counter() - begin < MAX_CATCH_UP_S:
                    mujoco.mj_step(model, data)
                if each_frame is not None:
                    each_frame(model, data)
            handle.sync()
            time.sleep(max(0.0, FRAME_S - (time.perf_counter() - begin)))


def require_screen() -> None:
    """Raise CasaError where no window can be opened. MuJoCo's viewer would end the whole process there."""
    messages: list[str] = []
    glfw.set_error_callback(lambda _, text: messages.append(os.fsdecode(text)))
    is_there = glfw.init()
    glfw.terminate()
    if not is_there:
        why = "; ".join(messages) or "GLFW finds no screen"
        raise CasaError(f"MuJoCo's viewer cannot open a window ({why}); --web shows a page instead")


def shown_groups(model: Any) -> list[int]:
    """Which groups of geoms the viewer shows at first, one number for each: what is seen and not what collides.

    The viewer shows 0, 1 and 2. That is right for MuJoCo's custom (visuals in 2, colliders in 3); a model for robosuite
    has colliders in 0 and visuals in 1.
    """
    used = {int(group) for group in model.geom_group}
    hidden = {0} if 1 in used and 0 in used else set()
    return [int(group < 3 and group not in hidden) for group in range(mujoco.mjNGROUP)]


class Glow:
    """The colours of the sites and visuals of a model while effects act on them."""

    def __init__(self, model: Any) -> None:
        """Remembers how everything looks; the model is an MjModel, whose colours `show` changes."""
        self._model = model
        self._sites, self._geoms = np.array(model.site_rgba), np.array(model.geom_rgba)
        self._materials = np.array(model.geom_matid)

    def show(self, effects: Mapping[str, Iterable[Effect]]) -> None:
        """Colour the targets of effects, and nothing else; `effects`: name of a fixture -> those that act."""
        model = self._model
        model.site_rgba[:], model.geom_rgba[:], model.geom_matid[:] = self._sites, self._geoms, self._materials
        for fixture, acting in effects.items():
            for effect in acting:
                if effect.kind in SEEN:
                    self._color(fixture, effect)

    def _color(self, fixture: str, effect: Effect) -> None:
        for name in (f"{fixture}__{effect.target}", effect.target):
            site = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_SITE, name)
            geom = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_GEOM, name)
            if site >= 0:
                self._model.site_rgba[site] = effect.color
            if geom >= 0:
                self._model.geom_rgba[geom], self._model.geom_matid[geom] = effect.color, -1
            if max(site, geom) >= 0:
                return
