"""Two small kitchens as batch forms are written, of different plans, to be put into one structure."""

from __future__ import annotations

from pathlib import Path

import mujoco

HEAD = """
  <compiler angle="radian" autolimits="true" fusestatic="true"/>
  <option timestep="0.002" integrator="implicitfast"><flag sleep="enable"/></option>
  <statistic center="1 -1 1" extent="3"/>
"""
SOLID = 'contype="3" conaffinity="0" condim="4" friction="0.5 0.005 0.0001" mass="0" group="2"'
LOOSE = 'contype="3" conaffinity="2" condim="4" friction="0.5 0.005 0.0001" mass="0" group="2"'
FIRST = f"""<mujoco model="first">{HEAD}
  <asset><texture name="sky" type="skybox" builtin="gradient" rgb1="0.6 0.7 0.9" rgb2="0.9 0.9 0.9" width="64" height="384"/></asset>
  <worldbody>
    <light name="sun" directional="true" pos="1 -3 4" dir="0 0.5 -0.8"/>
    <camera name="overview" pos="1 -4 2" quat="0.8 0.6 0 0"/>
    <geom name="floor__floor" type="box" size="2 2 0.05" pos="1 -1 -0.05" {SOLID} rgba="0.6 0.5 0.4 1"/>
    <geom name="top__slab" type="box" size="0.6 0.3 0.02" pos="1 -0.3 0.9" {SOLID} rgba="0.9 0.9 0.9 1"/>
    <body name="base" pos="0.4 -0.3 0">
      <body name="base__door" pos="0 -0.31 0.45">
        <inertial pos="0.3 0 0" mass="6" diaginertia="0.2 0.3 0.2"/>
        <joint name="base__hinge" type="hinge" axis="0 0 1" range="-1.5 0" damping="0.2" frictionloss="0.4"/>
        <geom name="base__front" type="box" size="0.28 0.01 0.4" pos="0.3 0 0" contype="7" conaffinity="4" condim="4" mass="0" rgba="0.2 0.3 0.5 1"/>
      </body>
    </body>
    <body name="corner" pos="1.62 -0.6 0">
      <body name="corner__drawer" pos="0 -0.02 0.6">
        <inertial pos="0 0.2 0" mass="5" diaginertia="0.1 0.1 0.1"/>
        <joint name="corner__slide" type="slide" axis="0 1 0" range="-0.4 0" damping="8" frictionloss="2"/>
        <geom name="corner__front" type="box" size="0.25 0.01 0.1" contype="7" conaffinity="4" condim="4" mass="0" rgba="0.2 0.3 0.5 1"/>
        <geom name="corner__bottom" type="box" size="0.24 0.2 0.01" pos="0 0.21 -0.09" contype="7" conaffinity="4" condim="4" mass="0" rgba="0.2 0.3 0.5 1"/>
        <site name="corner__place_site" pos="0 0.2 0" size="0.01" group="3"/>
        <site name="corner__ext_p0" pos="0 0 0" size="0.005" group="3"/>
      </body>
    </body>
    <body name="kettle" pos="1 -0.3 0.92">
      <freejoint name="kettle__free"/>
      <inertial pos="0 0 0.1" mass="1.2" diaginertia="0.006 0.006 0.004"/>
      <geom name="kettle__body" type="cylinder" size="0.08 0.1" pos="0 0 0.1" {LOOSE} rgba="0.7 0.7 0.7 1"/>
      <body name="kettle__lid" pos="-0.07 0 0.2">
        <inertial pos="0.07 0 0.005" mass="0.1" diaginertia="0.0002 0.0002 0.0003"/>
        <joint name="kettle__lid_hinge" type="hinge" axis="0 -1 0" range="0 1.2" damping="0.01"/>
        <geom name="kettle__lid_plate" type="cylinder" size="0.07 0.005" pos="0.07 0 0.002" {LOOSE} rgba="0.7 0.7 0.7 1"/>
      </body>
    </body>
    <body name="plate" pos="0.7 -0.3 0.92">
      <freejoint name="plate__free"/>
      <inertial pos="0 0 0.01" mass="0.4" diaginertia="0.001 0.001 0.002"/>
      <geom name="plate__disc" type="cylinder" size="0.12 0.01" pos="0 0 0.01" {LOOSE} rgba="1 1 1 1"/>
    </body>
  </worldbody>
  <contact><exclude body1="kettle" body2="kettle__lid"/></contact>
  <keyframe><key name="start" qpos="0 -0.1 1 -0.3 0.92 1 0 0 0 0 0.7 -0.3 0.92 1 0 0 0"/></keyframe>
</mujoco>"""
SECOND = f"""<mujoco model="second">{HEAD}
  <asset><texture name="sky" type="skybox" builtin="gradient" rgb1="0.6 0.7 0.9" rgb2="0.9 0.9 0.9" width="64" height="384"/></asset>
  <worldbody>
    <light name="sun" directional="true" pos="1 -3 4" dir="0 0.5 -0.8" diffuse="0.3 0.3 0.3"/>
    <light name="lamp_1" pos="1 -1 2" dir="0 0 -1"/>
    <camera name="overview" pos="2 -4 2" quat="0.8 0.6 0 0"/>
    <camera name="at_sink" pos="2 -2 2" quat="0.8 0.6 0 0"/>
    <geom name="floor__floor" type="box" size="3 3 0.05" pos="1 -1 -0.05" {SOLID} rgba="0.3 0.3 0.3 1"/>
    <geom name="wall__wall" type="box" size="3 0.05 1.3" pos="1 0.05 1.3" {SOLID} rgba="0.8 0.8 0.7 1"/>
    <geom name="top__slab" type="box" size="1 0.3 0.02" pos="1 -0.3 0.9" {SOLID} rgba="0.4 0.3 0.2 1"/>
    <geom name="tap__spout" type="capsule" size="0.02 0.1" pos="1 -0.15 1.05" {SOLID} rgba="0.7 0.7 0.7 1"/>
    <body name="left" pos="0.2 -0.61 0.45">
      <inertial pos="0.2 0 0" mass="4" diaginertia="0.1 0.2 0.1"/>
      <joint name="left__hinge" type="hinge" axis="0 0 1" range="-1.7 0" damping="0.2" frictionloss="0.3"/>
      <geom name="left__front" type="box" size="0.19 0.01 0.4" pos="0.2 0 0" contype="19" conaffinity="16" condim="4" mass="0" rgba="0.6 0.1 0.1 1"/>
      <geom name="left__handle" type="capsule" size="0.008 0.06" pos="0.36 -0.03 0.2" contype="19" conaffinity="16" condim="4" mass="0" rgba="0.6 0.6 0.6 1"/>
    </body>
    <body name="right" pos="1 -0.61 0.45">
      <inertial pos="-0.2 0 0" mass="4" diaginertia="0.1 0.2 0.1"/>
      <joint name="right__hinge" type="hinge" axis="0 0 1" range="0 1.7" damping="0.2" frictionloss="0.3"/>
      <geom name="right__front" type="box" size="0.19 0.01 0.4" pos="-0.2 0 0" contype="19" conaffinity="16" condim="4" mass="0" rgba="0.6 0.1 0.1 1"/>
    </body>
    <body name="oven" pos="1.5 -0.61 0.45">
      <inertial pos="0 0 0.2" mass="7" diaginertia="0.3 0.3 0.3"/>
      <joint name="oven__hinge" type="hinge" axis="1 0 0" range="0 1.5" damping="0.5" frictionloss="0.3" stiffness="3" springref="-0.2"/>
      <geom name="oven__flap" type="box" size="0.3 0.01 0.2" pos="0 0 0.2" {SOLID.replace('mass="0"', '')} mass="0" rgba="0.1 0.1 0.1 1"/>
    </body>
    <body name="mug" pos="1.4 -0.3 0.92">
      <freejoint name="mug__free"/>
      <inertial pos="0 0 0.05" mass="0.3" diaginertia="0.0004 0.0004 0.0003"/>
      <geom name="mug__wall" type="cylinder" size="0.04 0.05" pos="0 0 0.05" {LOOSE} rgba="0.2 0.6 0.3 1"/>
      <geom name="mug__ear" type="box" size="0.01 0.006 0.03" pos="0.05 0 0.05" {LOOSE} rgba="0.2 0.6 0.3 1"/>
    </body>
  </worldbody>
  <keyframe><key name="start" qpos="-0.2 0 0 1.4 -0.3 0.92 1 0 0 0"/></keyframe>
</mujoco>"""
ROBOT = """<mujoco model="bot"><worldbody><body name="base" pos="0 0 0.12">
  {joint}
  <geom type="box" size="0.2 0.2 0.1" mass="20"/>
  <body name="arm" pos="0 0 0.3">
    <joint name="lift" type="hinge" axis="0 1 0" damping="2"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="1"/>
  </body></body></worldbody>
  <actuator><position name="lift" joint="lift" kp="60"/></actuator>
  <keyframe><key name="home" qpos="{home}" ctrl="-0.4"/></keyframe></mujoco>"""
DRIVING = ROBOT.format(joint='<joint name="x" type="slide" axis="1 0 0" damping="50"/>', home="0.1 -0.4")
FLOATING = ROBOT.format(joint="<freejoint/>", home="5 5 0.11 1 0 0 0 -0.4")


def specs() -> list[mujoco.MjSpec]:
    """Both kitchens."""
    return [mujoco.MjSpec.from_string(text) for text in (FIRST, SECOND)]


def folders(out: Path) -> list[Path]:
    """Folders of scenes with the batch forms of both."""
    found = []
    for text in (FIRST, SECOND):
        name = text.split('model="')[1].split('"')[0]
        (out / name).mkdir(parents=True)
        (out / name / "scene_batch.xml").write_text(text)
        found.append(out / name)
    return found
