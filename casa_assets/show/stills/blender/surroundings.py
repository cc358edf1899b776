"""Surroundings of a room: sky through its windows and open sides, a low sun, the lamps, and the view outside.

If a plan leaves a room open, the room continues there, up to a wall with glazed doors to a garden. The floor, the
ceiling and the walls next to the opening are continued with their own pattern, so that a photographer who steps back
out of the kitchen is still in a room.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector
from surfaces import is_lamp, plain, stretched_noise

OUTSIDE_M = 0.35  # from the inner face of a wall to the light behind its window
SKY_RADIANCE, PATIO_RADIANCE = 9.0, 2.6
SUN_IRRADIANCE, SUN_SIZE_DEG = 26.0, 1.0
VEILED_IRRADIANCE, VEILED_SIZE_DEG = 8.0, 2.0  # behind the curtains of glazed doors, whose light is all over the room
SUN_ELEVATION_DEG, SUN_ASIDE_DEG = 33.0, 38.0  # of rooms that are seen from above
LAMP_W, LAMP_RADIUS_M, LAMP_GROUP_M = 14.0, 0.06, 0.45
THICK_M, LINTEL_M, PATIO_SHARE, PATIO_DOOR_M, PATIO_BAR_M = 0.12, 0.45, 0.72, 1.1, 0.055
SAME_PLANE_M = 0.01
SkyLight = Callable[[str, Vector, Vector, Vector], None]  # name, lower left and upper right corner, inward


def put(name: str, data: Any) -> Any:
    """A new thing in the scene: a light, a camera or a mesh."""
    thing = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(thing)
    return thing


def add_world(strength: float) -> Any:
    """A garden at midday, seen by cameras and mirrors alone. Returns the node whose strength may be set later."""
    world = bpy.context.scene.world = bpy.data.worlds.new("outside")
    tree = world.node_tree
    tree.nodes.clear()
    new, link = tree.nodes.new, tree.links.new
    view = new("ShaderNodeTexCoord")
    axes = new("ShaderNodeSeparateXYZ")
    link(view.outputs["Generated"], axes.inputs[0])
    sky = _ramp(
        tree, axes.outputs["Z"], ((0.0, (0.80, 0.88, 0.95)), (0.25, (0.47, 0.66, 0.92)), (1.0, (0.16, 0.34, 0.75)))
    )
    clouds = stretched_noise(tree, view.outputs["Generated"], (2.2, 2.2, 7.0), 6.0)
    cloudy = _ramp(tree, clouds, ((0.5, (0, 0, 0)), (0.72, (0.75, 0.75, 0.75))))
    sky = _mix(tree, cloudy, sky, (0.98, 0.98, 1.0))
    # The tops of trees: their height above the horizon is drawn from noise along it.
    crowns = stretched_noise(tree, view.outputs["Generated"], (9.0, 9.0, 1.5), 5.0)
    height = _math(tree, "MULTIPLY_ADD", crowns, 0.30, -0.035)
    is_tree = _math(tree, "MULTIPLY", _math(tree, "SUBTRACT", height, axes.outputs["Z"]), 60.0, clamp=True)
    # Softer than leaves are: a camera that is focused on the room blurs them.
    leaves = stretched_noise(tree, view.outputs["Generated"], (24.0, 24.0, 24.0), 2.0)
    green = _ramp(
        tree, leaves, ((0.32, (0.012, 0.032, 0.010)), (0.52, (0.055, 0.115, 0.030)), (0.72, (0.20, 0.29, 0.085)))
    )
    seen = _mix(tree, is_tree, sky, green)
    grass = stretched_noise(tree, view.outputs["Generated"], (14.0, 14.0, 90.0), 5.0)
    lawn = _ramp(tree, grass, ((0.3, (0.085, 0.13, 0.045)), (0.7, (0.17, 0.225, 0.085))))
    # A terrace near by.
    near = _math(tree, "MULTIPLY", _math(tree, "SUBTRACT", -0.22, axes.outputs["Z"]), 40.0, clamp=True)
    lawn = _mix(tree, near, lawn, (0.42, 0.39, 0.35))
    below = _math(tree, "MULTIPLY", _math(tree, "SUBTRACT", -0.01, axes.outputs["Z"]), 80.0, clamp=True)
    seen = _mix(tree, below, seen, lawn)
    background, output = new("ShaderNodeBackground"), new("ShaderNodeOutputWorld")
    background.inputs["Strength"].default_value = strength
    link(seen, background.inputs["Color"])
    link(background.outputs[0], output.inputs["Surface"])
    world.cycles_visibility.diffuse = False
    world.cycles.sampling_method = "NONE"
    return background


def _ramp(tree: Any, value: Any, stops: Sequence[tuple[float, tuple[float, float, float]]]) -> Any:
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    elements = ramp.color_ramp.elements
    while len(elements) < len(stops):
        elements.new(1.0)
    for element, (at, color) in zip(elements, stops, strict=True):
        element.position, element.color = at, (*color, 1.0)
    tree.links.new(value, ramp.inputs[0])
    return ramp.outputs[0]


def _mix(tree: Any, share: Any, below: Any, above: Any) -> Any:
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    factor, first, second = mix.inputs[0], mix.inputs[6], mix.inputs[7]
    tree.links.new(share, factor)
    tree.links.new(below, first)
    if isinstance(above, tuple):
        second.default_value = (*above, 1.0)
    else:
        tree.links.new(above, second)
    return mix.outputs[2]


def _math(tree: Any, operation: str, *values: Any, clamp: bool = False) -> Any:
    node = tree.nodes.new("ShaderNodeMath")
    node.operation, node.use_clamp = operation, clamp
    for socket, value in zip(node.inputs, values, strict=False):
        if isinstance(value, float):
            socket.default_value = value
        else:
            tree.links.new(value, socket)
    return node.outputs[0]


def light_room(room: dict[str, Any], beyond_m: float, sun: Sequence[float] | None) -> None:
    """Windows, doors with panes and open sides of a room of scene.json let in the sky, one the sun; lamps are on."""
    day, lamp = _take_out_lights()
    walls = {wall["id"]: wall for wall in room["walls"]}
    for opening in room["openings"]:
        if opening["kind"] not in ("passage", "niche") and not opening.get("closet"):
            start, end = Vector(opening["from"]), Vector(opening["to"])
            _sky_light(opening["id"], start, end, inward(walls[opening["wall"]]), SKY_RADIANCE, day)

    def let_in(name: str, low: Vector, high: Vector, into: Vector) -> None:
        _sky_light(name, low, high, into, PATIO_RADIANCE, day)

    close_all(room, beyond_m, let_in)
    if sun:
        clear = any(opening["kind"] == "window" for opening in room["openings"])
        strength = (SUN_IRRADIANCE, SUN_SIZE_DEG) if clear else (VEILED_IRRADIANCE, VEILED_SIZE_DEG)
        _sun(Vector(sun), day, *strength)
    light_lamps(lamp, LAMP_W)


def light_from_above(ahead: Vector) -> None:
    """An open box on a light table: an even sky, a soft sun from the side of the view `ahead`, lamps that are on."""
    day, lamp = _take_out_lights()
    add_even_world(0.55)
    aside = Matrix.Rotation(math.radians(SUN_ASIDE_DEG), 3, "Z") @ ahead
    down = math.tan(math.radians(SUN_ELEVATION_DEG))
    flat = Vector((aside.x, aside.y, 0.0)).normalized()
    _sun(flat - Vector((0.0, 0.0, down)), day, 2.4, 14.0)
    light_lamps(lamp, 3.0)
    bpy.ops.mesh.primitive_plane_add(size=400.0, location=(0.0, 0.0, -0.11))
    bpy.context.object.data.materials.append(plain("table", (0.82, 0.82, 0.81), 0.9))


def light_studio(points: Sequence[Vector]) -> None:
    """A table of neutral grey that bends up into the background, and three soft boxes, for things of any size."""
    low = Vector(min(p[k] for p in points) for k in range(3))
    high = Vector(max(p[k] for p in points) for k in range(3))
    middle, size = (low + high) / 2, max((high - low).length, 0.02)
    _take_out_lights()
    add_even_world(0.32)
    _sweep(middle, low.z, size)
    for name, way, wide, radiance in (
        ("key", Vector((0.75, -0.75, 0.95)), 1.5, 3.2),
        ("fill", Vector((-1.0, -0.55, 0.45)), 1.3, 0.9),
        ("rim", Vector((-0.35, 1.0, 1.0)), 1.1, 2.2),
    ):
        light = bpy.data.lights.new(name, "AREA")
        light.shape, light.size = "SQUARE", wide * size
        light.energy = math.pi * (wide * size) ** 2 * radiance
        thing = put(name, light)
        thing.location = middle + way.normalized() * 2.6 * size
        thing.rotation_euler = (middle - thing.location).to_track_quat("-Z", "Y").to_euler()
    light_lamps(Vector((1.0, 0.75, 0.5)), 0.3)


def _sweep(middle: Vector, bottom: float, size: float) -> None:
    """A floor that bends up behind the thing."""
    wide, back, bend = 40 * size, 3.2 * size, 1.6 * size
    profile = [(-8 * size, 0.0), (back - bend, 0.0)]
    profile += [
        (back - bend + bend * math.sin(a), bend - bend * math.cos(a)) for a in (k * math.pi / 48 for k in range(1, 25))
    ]
    profile.append((back, 14 * size))
    points = [(middle.x + x, middle.y + y, bottom + z) for y, z in profile for x in (-wide, wide)]
    mesh = bpy.data.meshes.new("studio")
    mesh.from_pydata(points, [], [(2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2) for k in range(len(profile) - 1)])
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.append(plain("studio", (0.66, 0.66, 0.655), 0.55))
    put("studio", mesh)


def add_even_world(strength: float) -> None:
    """The same light from all sides."""
    world = bpy.context.scene.world = bpy.data.worlds.new("even")
    shader = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    shader.inputs["Color"].default_value, shader.inputs["Strength"].default_value = (1.0, 1.0, 1.0, 1.0), strength


def _take_out_lights() -> tuple[Vector, Vector]:
    """Remove the lights of USD, which are made for rooms without a ceiling; colours of its sun and its lamps."""
    colors = {"SUN": Vector((1.0, 0.97, 0.95)), "POINT": Vector((1.0, 0.75, 0.5))}
    for thing in [o for o in bpy.data.objects if o.type == "LIGHT"]:
        color = Vector(thing.data.color)
        if thing.data.type in colors and color.length > 0 and not thing.name.startswith("fill"):
            colors[thing.data.type] = color / max(color)
        bpy.data.objects.remove(thing, do_unlink=True)
    return colors["SUN"], colors["POINT"]


def _sky_light(name: str, start: Vector, end: Vector, into: Vector, radiance: float, color: Sequence[float]) -> None:
    """A lit rectangle behind an opening whose lower left and upper right corner are given."""
    flat = Vector((end.x - start.x, end.y - start.y, 0.0))
    wide, high = flat.length * 1.15, (end.z - start.z) * 1.15
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.size, light.size_y = "RECTANGLE", wide, high
    light.energy, light.color = math.pi * wide * high * radiance, color[:3]
    thing = put(name, light)
    # A light shines along its -z; its y points up.
    back = -into
    right = Vector((0, 0, 1)).cross(back).normalized()
    turn = Matrix((right, Vector((0, 0, 1)), back)).transposed().to_4x4()
    thing.matrix_world = Matrix.Translation((start + end) / 2 - into * OUTSIDE_M) @ turn
    thing.visible_camera = thing.visible_transmission = False


def _sun(along: Vector, color: Sequence[float], irradiance: float, size_deg: float) -> None:
    light = bpy.data.lights.new("sun", "SUN")
    light.energy, light.angle = irradiance, math.radians(size_deg)
    light.color = (1.0, 0.93 * color[1], 0.84 * color[2])
    thing = put("sun", light)
    thing.rotation_euler = along.to_track_quat("-Z", "Y").to_euler()


def light_lamps(color: Sequence[float], power: float) -> None:
    """A light in the middle of each group of bulbs, which themselves throw no shadow."""
    glowing = [o for o in bpy.data.objects if o.type == "MESH" and any(is_lamp(s.material) for s in o.material_slots)]
    groups: list[list[Vector]] = []
    for thing in glowing:
        thing.visible_shadow = False
        middle = sum((thing.matrix_world @ Vector(c) for c in thing.bound_box), Vector()) / 8
        group = next((g for g in groups if (g[0] - middle).length < LAMP_GROUP_M), None)
        if group is None:
            groups.append([middle])
        else:
            group.append(middle)
    for k, group in enumerate(groups):
        middle = sum(group, Vector()) / len(group)
        light = bpy.data.lights.new(f"lamp_{k}", "POINT")
        light.energy, light.color = power, color[:3]
        light.shadow_soft_size = LAMP_RADIUS_M
        thing = put(f"lamp_{k}", light)
        thing.location = middle
        thing.visible_camera = thing.visible_glossy = thing.visible_transmission = False


def inward(wall: dict[str, Any]) -> Vector:
    """Direction from a wall into the room: walls go clockwise, seen from above."""
    along = (Vector(wall["to"]) - Vector(wall["from"])).normalized()
    return Vector((along.y, -along.x, 0.0))


def close_all(room: dict[str, Any], beyond_m: float, let_in: SkyLight) -> None:
    """Build what lies beyond each open side; `let_in` makes the light behind the glazed doors."""
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
    known = [o for o in bpy.data.objects if o.type == "MESH" and o.name.startswith(prefix)]
    largest = sorted(known, key=lambda o: (-max(o.dimensions), o.name))
    source = next((o for o in largest if _lies_in(o, corners[0], normal)), None)
    if source is None or not source.data.uv_layers:
        mesh.materials.append(_paint())
    else:
        mesh.materials.append(source.material_slots[0].material)
        _continue_pattern(source, mesh)
    put(mesh.name, mesh)


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
    for a, b, low in ((0, half, 0), (length - half, length, 0), (half, length - half, top)):
        _block(f"closing_{name}", start + along * a, along * (b - a), into * -THICK_M, low, height, _paint())
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
    put(name, mesh)
