"""Checks of kitchens and of forms that are made of them, and the registry, which has their limits."""

from __future__ import annotations

from casa_assets.checks.check import run as run_checks
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.checks.design.tasks import ATOMIC_TASKS
from casa_assets.checks.readers.mujoco_facts import native_warnings
from casa_assets.checks.robots import Task, tasks_of
from casa_assets.checks.scene.engine_sizes import engine_sizes
from casa_assets.checks.scene.light_forms import BatchSubject, candidate_pairs
from casa_assets.registry import load as load_registry
from casa_assets.registry.tables import load_robot

__all__ = [
    "ATOMIC_TASKS",
    "BatchSubject",
    "candidate_pairs",
    "DesignSubject",
    "engine_sizes",
    "load_registry",
    "load_robot",
    "native_warnings",
    "run_checks",
    "Task",
    "tasks_of",
]
