"""Gives robosuite 1.5.2 what RoboCasa v1.0 expects of a robosuite that is on no package index yet.

Nothing of RoboCasa is touched. Runs in RoboCasa's own environment; call `install` before the first environment is made.
"""

from __future__ import annotations

from typing import Any

from robosuite.controllers.parts import controller_factory
from robosuite.environments.base import MujocoEnv
from robosuite.environments.manipulation.manipulation_env import ManipulationEnv
from robosuite.models.tasks import ManipulationTask
from robosuite.utils.mjcf_utils import find_elements, new_element

# What MujocoEnv.__init__ of 1.5.2 does after it has noted its arguments; `reset` does all of it again.
LOADING = ("_load_model", "_initialize_sim", "initialize_renderer", "_reset_internal", "_setup_observables")


def install() -> None:
    """Adds the missing keywords and the missing type of controller to robosuite's classes."""
    _load_on_reset()
    _multiccd()
    _legacy_base()


def _load_on_reset() -> None:
    """`load_model_on_init=False`: the model is made by the first reset alone, and until then there is no `sim`."""
    made = ManipulationEnv.__init__
    MujocoEnv.sim = None

    def init(self: Any, *arguments: Any, load_model_on_init: bool = True, **keywords: Any) -> None:
        if not load_model_on_init:
            vars(self).update(dict.fromkeys(LOADING, dict))  # `_setup_observables` finds none
        made(self, *arguments, **keywords)
        if not load_model_on_init:
            for name in LOADING:
                delattr(self, name)

    ManipulationEnv.__init__ = init


def _multiccd() -> None:
    """`enable_multiccd` and `enable_sleeping_islands` of a task; MuJoCo 3.3.1 knows the first alone."""
    made = ManipulationTask.__init__

    def init(
        self: Any,
        *arguments: Any,
        enable_multiccd: bool = False,
        enable_sleeping_islands: bool = False,
        **keywords: Any,
    ) -> None:
        made(self, *arguments, **keywords)
        assert not enable_sleeping_islands, "MuJoCo 3.3.1 has no islands that sleep"
        if enable_multiccd:
            option = find_elements(self.root, "option", return_first=True)
            option.append(new_element("flag", None, multiccd="enable"))

    ManipulationTask.__init__ = init


def _legacy_base() -> None:
    """JOINT_VELOCITY_LEGACY is what robosuite 1.5.2 calls JOINT_VELOCITY."""
    of_now = controller_factory.mobile_base_controller_factory

    def factory(name: str, params: Any) -> Any:
        return of_now("JOINT_VELOCITY" if name == "JOINT_VELOCITY_LEGACY" else name, params)

    controller_factory.mobile_base_controller_factory = factory
