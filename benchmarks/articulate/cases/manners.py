"""Manners of modelling: changes that go together, drawn at random."""

from __future__ import annotations

import zlib

import numpy as np

from benchmarks.articulate.cases.changes import CHANGES
from benchmarks.articulate.cases.labelled import LabelledMesh
from benchmarks.articulate.cases.surfaces import by_position

# For each manner the changes in their order: at each step at most one, with these probabilities.
MANNERS: dict[str, tuple[dict[str, float], ...]] = {
    # Drawn by pushing and pulling faces, exported with both sides of each face.
    "sketch": (
        {"no_handles": 0.3},
        {"box_drawers": 0.5},
        {"flat_controls": 0.2},
        {"touching": 0.65, "coincident": 0.2},
        {"empty_inside": 0.6},
        {"split_groups": 0.25, "loose_pieces": 0.15},
        {"double_faces": 0.9},
        {"axes": 0.5},
    ),
    # Few triangles, one shell, controls in the picture on it.
    "game": (
        {"no_handles": 0.25},
        {"box_drawers": 0.5},
        {"flat_controls": 0.7},
        {"touching": 0.3, "one_shell": 0.4},
        {"empty_inside": 0.8},
        {"decimated": 0.7},
        {"axes": 0.5},
    ),
    # Out of a program for parts: each face of a solid is a component.
    "solid": (
        {"box_drawers": 0.3},
        {"coincident": 0.5},
        {"split_groups": 0.8, "loose_pieces": 0.2},
        {"axes": 0.5},
    ),
    # Sampled from a real thing.
    "scan": (
        {"no_handles": 0.2},
        {"touching": 0.5},
        {"empty_inside": 1.0},
        {"decimated": 0.3},
        {"holes": 0.5},
        {"noise": 0.8},
        {"axes": 0.5},
    ),
}


def in_manner(mesh: LabelledMesh, manner: str, seed: int) -> tuple[LabelledMesh, list[str]]:
    """A case in a manner, and the changes that were drawn."""
    rng = np.random.default_rng([seed, zlib.crc32(f"{mesh.truth['name']} {manner}".encode())])
    taken = []
    for step in MANNERS[manner]:
        left = float(rng.random())
        for name, share in step.items():
            if 0 <= left < share:
                mesh = CHANGES[name](mesh, rng)
                taken.append(name)
            left -= share
    if manner == "game" and rng.random() < 0.5 and "one_shell" not in taken:
        mesh = by_position(mesh)
        taken.append("by_position")
    return mesh, taken
