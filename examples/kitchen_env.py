"""A kitchen as a Gymnasium environment: a fingertip is moved until a fixture is in the state that is asked for.

    MUJOCO_GL=egl python examples/kitchen_env.py out/press.png    # presses the start button of a microwave

Needs gymnasium (`pip install -e '.[gymnasium]'`). Lengths are metres, times seconds.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image

import casa_assets as casa

Array = NDArray[np.float32]
# A ball that is pushed by up to 20 N along each axis. A robot takes its place: mujoco.MjSpec.from_file("robot.xml").
FINGER = """
<mujoco>
  <worldbody><body name="finger" gravcomp="1">
    <joint name="finger_x" type="slide" axis="1 0 0"/>
    <joint name="finger_y" type="slide" axis="0 1 0"/>
    <joint name="finger_z" type="slide" axis="0 0 1"/>
    <geom size="0.008" mass="0.2" rgba="1 0.2 0.1 1"/>
  </body></worldbody>
  <actuator>
    <velocity joint="finger_x" kv="100" ctrlrange="-0.3 0.3" forcerange="-20 20"/>
    <velocity joint="finger_y" kv="100" ctrlrange="-0.3 0.3" forcerange="-20 20"/>
    <velocity joint="finger_z" kv="100" ctrlrange="-0.3 0.3" forcerange="-20 20"/>
  </actuator>
</mujoco>"""


class Task(NamedTuple):
    """What has to be done: `state`, a variable or a joint of `fixture`, gets `value`; `target` is the geom to go to."""

    fixture: str
    state: str
    value: str
    target: str
    plan: str
    style: str


START_MICROWAVE = Task("microwave", "power", "on", "microwave__start_button", "l_small", "coastal")


class KitchenEnv(gymnasium.Env[Array, Array]):
    """Action: velocity of the fingertip, 1 is 0.3 m/s. Observation: its place from the target, m, and velocity, m/s."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012  as gymnasium has it

    def __init__(
        self, task: Task = START_MICROWAVE, detail: casa.Detail = "full", render_mode: str | None = None
    ) -> None:
        self.action_space = gymnasium.spaces.Box(-1, 1, (3,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-10, 10, (6,), np.float32)
        kitchen = casa.kitchen(task.plan, task.style, detail=detail)
        spec = kitchen.to_mjspec()
        spec.attach(mujoco.MjSpec.from_string(FINGER), frame=spec.worldbody.add_frame())
        self.model = spec.compile()
        self.data, self.behaviors = mujoco.MjData(self.model), casa.Behaviors(self.model)
        self.task, self.target, self.render_mode = task, self.model.geom(task.target).id, render_mode
        self.yaw = kitchen.facts["parking"][task.fixture]["shut"]["yaw"]  # where a robot before the fixture looks
        self.renderer = mujoco.Renderer(self.model, 240, 320) if render_mode else None
        # The light form has no pictures to change.
        self.textures = kitchen.textures_of(self.model) if render_mode and detail == "full" else None
        self.choices = {surface: names[:3] for surface, names in casa.surfaces().items()}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Put all as a keyframe has it (`options={"key": "open"}`), the fingertip before the target, paint the room."""
        super().reset(seed=seed)
        mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.key((options or {}).get("key", "closed")).id)
        mujoco.mj_forward(self.model, self.data)
        away = self.np_random.uniform(-0.03, 0.03, 3) - 0.15 * np.array([np.cos(self.yaw), np.sin(self.yaw), 0])
        self.data.qpos[-3:] = self.data.geom_xpos[self.target] + away
        mujoco.mj_forward(self.model, self.data)
        drawn = {surface: str(self.np_random.choice(names)) for surface, names in self.choices.items()}
        if self.textures and self.renderer:
            self.textures.show(drawn)
            self.textures.upload(self.renderer)
        return self._observation(), {"states": self.behaviors.reset(self.data)}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Go on for 0.05 s; it ends when the fixture's own state machine says so."""
        self.data.ctrl[-3:] = 0.3 * action
        mujoco.mj_step(self.model, self.data, nstep=25)
        states, observation = self.behaviors.update(self.data), self._observation()
        success = states[self.task.fixture][self.task.state] == self.task.value
        reward = float(success) - float(np.linalg.norm(observation[:3]))
        return observation, reward, success, False, {"states": states, "is_success": success}

    def render(self) -> Any:
        """(240, 320, 3) picture, seen past who stands before the fixture; None without a render mode."""
        if self.renderer:
            camera = mujoco.MjvCamera()
            camera.lookat, camera.distance = self.data.geom_xpos[self.target], 0.7
            camera.azimuth, camera.elevation = np.degrees(self.yaw) + 20, -20
            self.renderer.update_scene(self.data, camera)
        return self.renderer.render() if self.renderer else None

    def _observation(self) -> Array:
        away = self.data.qpos[-3:] - self.data.geom_xpos[self.target]
        seen: Array = np.clip(np.concatenate([away, self.data.qvel[-3:]]), -10, 10).astype(np.float32)
        return seen


def main() -> None:
    """Press the button by going straight at it; draw the last moment into the file that is named."""
    env = KitchenEnv(render_mode="rgb_array")
    observation, info = env.reset(seed=0)
    for step in range(100):
        observation, reward, success, _, info = env.step(np.clip(-20 * observation[:3], -1, 1))
        if success:
            print(f"step {step}: reward {reward:.2f}, the microwave says {info['states']['microwave']}")
            break
    picture = Path(sys.argv[1])
    picture.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(env.render()).save(picture)


if __name__ == "__main__":
    main()
