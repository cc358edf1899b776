"""Python's start on a machine that has another version of one package."""

from __future__ import annotations

import importlib.metadata

version = importlib.metadata.version
importlib.metadata.version = lambda name: "0.0.1" if name == "mujoco" else version(name)
