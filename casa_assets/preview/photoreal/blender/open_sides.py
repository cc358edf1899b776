"""Where a plan leaves a room open: the room goes on, up to a wall with glazed doors to a garden.

The floor, the ceiling and the walls beside the opening are continued with their own pattern, so that a photographer who
steps back out of the kitchen still stands in a room.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from surfaces import plain

THICK_M, LINTEL_M, PATIO_SHARE, PATIO_DOOR_M, PATIO_BAR_M = 0.12, 0.45, 0.72, 1.1, 0.055
SAME_PLANE_M = 0.01
SkyLight = Callable[[str, Vector, Vector, Vector], None]  # name, lower left and upper right corner, inward


def inward(wall: dict[str, Any]) -> Vector:
    """Direction from a wall into the room: walls go clockwise, seen from above."""
    along = (Vector(wall["to"]) - Vector(wall["from"])).normalized()
    return Vector((along.y, -along.x, 0.0))


def close_all(room: dict[str, Any], beyond_m: float, let_in: SkyLight) -> None:
    """Build what lies beyond each open side.

    Args:
        room: as in scene.json. beyond_m: depth of what is added. let_in: makes the light behind the glazed doors.
    """
    walls = room["walls"]
    for wall in [wall for wall in walls if wall["open"]]:
        before = next(w for w in walls if w["to"] == wall["from"])
        after = next(w for w in walls if w["from"] == wall["to"])
        _close(wall, bool(before["open"]), bool(after["open"]), room["bounds"][1][2], beyond_m, let_in)


def _close(
    wall: dict[str, Any], open_before: bool, open_after: bool, height: float, beyond_m: float, let_in: SkyLight
) -> None:
    start, end, into = Vector(wall["from"]), Vector(wall["to"]), inward(wall)
    along, out, up = (end - start).normalized(), into * -beyond_m, Vector((0.0, 0.0, height))
    # Beyond a corner with two open sides the square belongs to the floor of the first, and both far walls meet.
    wide = end + along * beyond_m if open_after else end
    far_start = (start - along * beyond_m if open_before else start) + out
    _continue("floor_visual", [start, wide, wide + out, start + out])
    _continue("ceiling_visual", [p + up for p in (start, wide, wide + out, start + out)])
    if not open_before:
        _continue("wall_visual", [start, start + out, start + out + up, start + up])
    if not open_after:
        _continue("wall_visual", [end, end + out, end + out + up, end + up])
    _glaze(wall["id"], far_start, wide + out, into, height, let_in)


def _continue(prefix: str, corners: Sequence[Vector]) -> None:
    """Add a rectangle that carries on the pattern of the imported surface that lies in its plane."""
    normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalized()
    mesh = bpy.data.meshes.new(f"beyond_{prefix}")
    mesh.from_pydata(list(corners), [], [(0, 1, 2, 3)])
    source = next((o for o in _surfaces(prefix) if _lies_in(o, corners[0], normal)), None)
    if source is None or not source.data.uv_layers:
        mesh.materials.append(_paint())
    else:
        mesh.materials.append(source.material_slots[0].material)
        _continue_pattern(source, mesh)
    bpy.context.collection.objects.link(bpy.data.objects.new(mesh.name, mesh))


def _surfaces(prefix: str) -> list[Any]:
    """Imported meshes of a kind, the largest first."""
    found = [o for o in bpy.data.objects if o.type == "MESH" and o.name.startswith(prefix)]
    return sorted(found, key=lambda o: (-max(o.dimensions), o.name))


def _lies_in(thing: Any, point: Vector, normal: Vector) -> bool:
    places = [thing.matrix_world @ vertex.co for vertex in thing.data.vertices]
    return all(abs((place - point).dot(normal)) < SAME_PLANE_M for place in places)


def _continue_pattern(source: Any, mesh: Any) -> None:
    """Give a mesh texture coordinates by the affine map (least squares) from places to coordinates of another."""
    layer = source.data.uv_layers[0]
    places = [[*(source.matrix_world @ source.data.vertices[loop.vertex_index].co), 1.0] for loop in source.data.loops]
    known = np.array([tuple(layer.data[loop.index].uv) for loop in source.data.loops])
    mapped = np.linalg.lstsq(np.array(places), known, rcond=None)[0]
    target = mesh.uv_layers.new(name=layer.name)
    for loop in mesh.loops:
        target.data[loop.index].uv = np.array([*mesh.vertices[loop.vertex_index].co, 1.0]) @ mapped


def _paint() -> Any:
    return bpy.data.materials.get("closing_wall") or plain("closing_wall", (0.72, 0.70, 0.67), 0.7)


def _glaze(name: str, start: Vector, end: Vector, into: Vector, height: float, let_in: SkyLight) -> None:
    """A wall with a wide opening towards the garden, glazed doors in it."""
    along, length, top = (end - start).normalized(), (end - start).length, height - LINTEL_M
    half = length * (1 - PATIO_SHARE) / 2
    for a, b, low, high in (
        (0, half, 0, height),
        (length - half, length, 0, height),
        (half, length - half, top, height),
    ):
        _block(f"closing_{name}", start + along * a, along * (b - a), into * -THICK_M, low, high, _paint())
    left, right = start + along * half, start + along * (length - half) + Vector((0, 0, top))
    let_in(f"patio_{name}", left, right, into)
    frame = bpy.data.materials.get("patio_frame") or plain("patio_frame", (0.03, 0.03, 0.032), 0.45)
    count = max(2, round((length - 2 * half) / PATIO_DOOR_M))
    across = into * -PATIO_BAR_M
    for k in range(count + 1):
        at = half + (length - 2 * half - PATIO_BAR_M) * k / count
        _block("patio_bar", start + along * at, along * PATIO_BAR_M, across, 0, top, frame)
    for low in (0.0, top - PATIO_BAR_M):
        _block("patio_bar", start + along * half, along * (length - 2 * half), across, low, low + PATIO_BAR_M, frame)


def _block(name: str, at: Vector, along: Vector, across: Vector, low: float, high: float, material: Any) -> None:
    corners = [at, at + along, at + along + across, at + across]
    points = [p + Vector((0, 0, z)) for z in (low, high) for p in corners]
    faces = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    mesh.materials.append(material)
    bpy.context.collection.objects.link(bpy.data.objects.new(name, mesh))
