"""Meshes that a node places many times by a list of translations, rotations and scales: EXT_mesh_gpu_instancing."""

from __future__ import annotations

from dataclasses import replace

from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf.accessor import Accessors
from casa_assets.ingest.load.gltf.graph import MeshInstance, SceneGraph, placing_matrix
from casa_assets.ingest.load.gltf.tree import JsonObject
from casa_assets.ingest.load.notes import Notes

EXTENSION = "EXT_mesh_gpu_instancing"
# Copies that are read of one file, a choice: more of them say nothing new of what the file holds.
MAX_COPIES = 256
# What a copy has where a column is missing.
_STILL: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("TRANSLATION", (0.0, 0.0, 0.0)),
    ("ROTATION", (0.0, 0.0, 0.0, 1.0)),
    ("SCALE", (1.0, 1.0, 1.0)),
)


def with_instances(
    document: JsonObject, accessors: Accessors, graph: SceneGraph, notes: Notes
) -> tuple[SceneGraph, int]:
    """The graph with a placed mesh for each copy that a node asks for, and how many these are in all.

    Copies of a node are counted from 1. Of a file no more than `MAX_COPIES` are read, with a note.

    Raises:
        Rejected: codes of accessors.
    """
    placed: list[MeshInstance] = []
    copies = left_out = 0
    for one in graph.placed:
        attributes = _attributes(document, one)
        if attributes is None:
            placed.append(one)
            continue
        columns = {
            name: accessors.floats(attributes.count(name), (len(still),))
            for name, still in _STILL
            if attributes.has(name)
        }
        count = min((len(rows) for rows in columns.values()), default=0)
        read = min(count, MAX_COPIES - copies)
        left_out += count - read
        copies += read
        for i in range(read):
            row = [columns[name][i].tolist() if name in columns else list(still) for name, still in _STILL]
            placed.append(replace(one, world_from_mesh=one.world_from_mesh @ placing_matrix(*row), copy_number=i + 1))
    if copies:
        message = f"{copies} copies of meshes ({EXTENSION}) are read as things of their own"
        notes.add(codes.FEATURE_IGNORED, "nodes", message + (f"; {left_out} more are left out" if left_out else ""))
    return (SceneGraph(tuple(placed), graph.world_from_node), copies) if copies else (graph, 0)


def _attributes(document: JsonObject, placed: MeshInstance) -> JsonObject | None:
    """What the extension says of a placed mesh; None where it has none."""
    if placed.node is None:
        return None
    extensions = document.pick(placed.node, "nodes").child("extensions")
    return extensions.child(EXTENSION).child("attributes") if extensions.has(EXTENSION) else None
