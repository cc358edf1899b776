"""Render assets to pictures: stills, turntables, strips of what moves, and raw models, of which no MJCF exists."""

from __future__ import annotations

import colorsys
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from casa_assets.core.numeric import Floats, srgb_from_linear_array
from casa_assets.errors import CasaError
from casa_assets.model.asset.material import Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawModel, RawPart, Up
from casa_assets.show.stills import pictures, studio
from casa_assets.show.stills.pictures import Pixels, SheetCell, cell_corner, contact_sheet
from casa_assets.show.stills.studio import Camera, View, fit

# Groups of the geoms that are seen and of those that collide: the first number in model.xml, the second in what MuJoCo
# reads from USD.
_VISUAL_GROUPS, _COLLISION_GROUPS = (1, 2), (0, 3)
_DEFAULT_VIEW = View()
# A picture of colliders shows them over the thing in this grey, with this share of their colour.
_GREY_RGBA = (0.86, 0.87, 0.88, 1.0)
_COLLIDER_OPACITY = 0.68
_MIN_OVERLAY_PASSES = 8
# Hues of colliders: the golden ratio as a share of the circle keeps any number of them apart.
_FIRST_HUE, _HUE_STEP = 0.58, 0.61803398875
_TURNTABLE_VIEW = View(size_px=256, fill=0.92, passes=10)
_RAW_VIEW = View(size_px=320, passes=16)
# Above this many faces MuJoCo takes longer to read a mesh than the picture is worth: vertices are moved onto a grid of
# this many steps along the longest side, about one for each pixel, and faces that become alike are drawn once.
_MANY_FACES, _GRID_STEPS = 150_000, 256
_SMALL_FACES = 20_000  # from this number on each is small
_LEAST_VERTICES = 4  # of a mesh that MuJoCo reads
_LARGEST_PX = 1024  # of an image
CELL_PX, COLUMNS = 320, 6
# A review wants to see what is there, not soft shadows.
_VIEW = View(size_px=CELL_PX, passes=6)
_BODY = (0.82, 0.83, 0.85)
# Parts that are taken apart go this far, in diagonals of the thing; what sits on a part goes as far again.
_APART = 0.16
_DARK = (25, 27, 31)


class CannotDraw(CasaError):
    """A model cannot be drawn; the message says why."""


def render(model_xml: Path, view: View = _DEFAULT_VIEW, collision: bool = False, pose: str = "") -> bytes:
    """PNG of one asset in a keyframe, or with joints at zero, from the front and a little from its right and above.

    Args:
        model_xml: MJCF with visual geoms in group 1 and collision geoms in group 0, or USD with 2 and 3.
        collision: show each collider in a different colour, see-through, over the asset in grey.
    Raises:
        CannotDraw: MuJoCo cannot read the model, it has no such keyframe, or nothing in it is visible. NoRenderer.
    """
    if collision:
        return _render_colliders(model_xml, view, pose)
    model, data, points = load_into_studio(model_xml, view.size_px, pose=pose)
    return pictures.png(studio.render(model, data, points, fit(points, view), view))


def _render_colliders(model_xml: Path, view: View, pose: str) -> bytes:
    """PNG of the colliders over the grey thing, two pictures: in one scene surfaces that coincide would flicker."""
    thing, thing_data, thing_points = load_into_studio(model_xml, view.size_px, _GREY_RGBA, pose=pose)
    shapes, shape_data, shape_points = load_into_studio(model_xml, view.size_px, None, _COLLISION_GROUPS, pose)
    camera = fit(np.concatenate([thing_points, shape_points]), view)
    # Half the drawings for each of the two.
    fewer = replace(view, passes=max(_MIN_OVERLAY_PASSES, view.passes // 2))
    below = studio.render(thing, thing_data, thing_points, camera, fewer).astype(np.float64)
    above = studio.render(shapes, shape_data, shape_points, camera, fewer).astype(np.float64)
    return pictures.png(np.rint(below + _COLLIDER_OPACITY * (above - below)).astype(np.uint8))


def load_into_studio(
    model_xml: Path,
    size_px: int,
    paint: tuple[float, ...] | None = None,
    groups: tuple[int, ...] = _VISUAL_GROUPS,
    pose: str = "",
) -> tuple[Any, Any, Floats]:
    """Compile the geoms of these groups of an asset in the studio: (MjModel, MjData, (N, 3) visible points in metres).

    Args:
        paint: RGBA for everything, instead of its materials.
    Raises:
        CannotDraw: MuJoCo cannot read the model, or it has no geom to show.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(model_xml))
        _keep_groups(spec, groups, paint)
        add_highlights(spec)
        studio.add_studio(spec, size_px)
        model = spec.compile()
    except ValueError as error:
        raise CannotDraw(f"{model_xml.name}: {error}".replace("\n", " ")) from error
    data = mujoco.MjData(model)
    if pose:
        set_keyframe(model, data, pose, model_xml.name)
    mujoco.mj_forward(model, data)
    return model, data, studio.place_floor(model, data)


def set_keyframe(model: Any, data: Any, pose: str, name: str) -> None:
    """Set the data to a keyframe. Raises CannotDraw where the model, here called `name`, has none such."""
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, pose)
    if key < 0:
        known = ", ".join(model.key(i).name for i in range(model.nkey)) or "none"
        raise CannotDraw(f"{name}: it has no keyframe {pose!r}; there are {known}")
    mujoco.mj_resetDataKeyframe(model, data, key)


def poses(model_xml: Path) -> tuple[str, ...]:
    """Names of the keyframes of a model, in its order."""
    return tuple(key.name for key in mujoco.MjSpec.from_file(str(model_xml)).keys)


def add_highlights(spec: Any) -> None:
    """Set specular and shininess of an MjSpec's materials from metallic and roughness."""
    for material in spec.materials:
        color = list(material.rgba)
        phong = _phong_terms(material.metallic, material.roughness, color, material.textures)
        material.specular, material.shininess, factor = phong
        material.reflectance = 0.0
        material.rgba = [*(factor * c for c in color[:3]), color[3]]


def _phong_terms(metallic: float, roughness: float, rgba: Any, textures: Any) -> tuple[float, float, float]:
    """(specular, shininess, factor of the colour) that show metallic and roughness, which are negative if not stated.

    `textures`: one item for each role, true where a picture fills it.
    """
    metallic = max(0.0, metallic)
    smooth = 1.0 - (roughness if roughness >= 0.0 else 0.5)
    # Metal mirrors in its own colour: a black one shines less than chrome.
    bright = max(rgba[:3]) if not any(textures) else 1.0
    specular = (1.0 - metallic) * (0.08 + 0.2 * smooth) + metallic * 0.9 * bright
    return specular, 0.05 + 0.45 * smooth**2, 1.0 - metallic * (0.14 + 0.42 * smooth)


def _keep_groups(spec: Any, groups: tuple[int, ...], paint: tuple[float, ...] | None) -> None:
    """Delete geoms of other groups, regions, and meshes that no geom uses, and put the rest into the studio's group.

    Each collider gets a different colour, or everything gets `paint`. Raises ValueError if no geoms remain.
    """
    for geom in list(spec.geoms):
        if geom.group not in groups or geom.name.startswith("reg_"):
            spec.delete(geom)
    if not list(spec.geoms):
        raise ValueError(f"it has no geom in group {' or '.join(map(str, groups))} to be drawn")
    for i, geom in enumerate(spec.geoms):
        if groups == _COLLISION_GROUPS or paint is not None:
            geom.material, geom.rgba = "", list(paint or (*_color(i), 1.0))
        geom.group = studio.VISUAL_GROUP
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)


def _color(i: int) -> tuple[float, float, float]:
    hue, saturation, brightness = (_FIRST_HUE + i * _HUE_STEP) % 1.0, (0.75, 0.55)[i % 2], (0.95, 0.85)[i // 2 % 2]
    return colorsys.hsv_to_rgb(hue, saturation, brightness)


def render_turntable(model_xml: Path, view: View = _TURNTABLE_VIEW, frames: int = 24, seconds: float = 4.0) -> bytes:
    """Animated WebP of the asset turning once in some seconds, without end. Raises CannotDraw, NoRenderer."""
    model, data, points = load_into_studio(model_xml, view.size_px)
    swept = _swept(points)
    taken: list[pictures.Pixels] = []
    for i in range(frames):
        # The camera walks round with the lights, which looks as if the thing turned under them.
        turned = replace(view, azimuth_deg=view.azimuth_deg + 360.0 * i / frames)
        camera = fit(swept, turned)
        taken.append(studio.render(model, data, points, camera, turned))
    first, *rest = [Image.fromarray(pixels) for pixels in taken]
    out, each_ms = io.BytesIO(), round(1000.0 * seconds / frames)
    first.save(out, format="WEBP", save_all=True, append_images=rest, duration=each_ms, loop=0, quality=80, method=4)
    return out.getvalue()


def _swept(points: Floats) -> Floats:
    """Rings about the vertical axis that hold all points, so that every frame has the same distance and aim."""
    middle = (points[:, :2].max(axis=0) + points[:, :2].min(axis=0)) / 2.0
    radius = np.linalg.norm(points[:, :2] - middle, axis=1)
    around = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
    rings = []
    # The widest point of each of some layers is enough.
    edges = np.linspace(points[:, 2].min(), points[:, 2].max(), 17)
    layer = np.clip(np.searchsorted(edges, points[:, 2], side="right") - 1, 0, 15)
    for k in range(16):
        mine = layer == k
        if mine.any():
            reach = float(radius[mine].max())
            for z in (float(points[mine, 2].min()), float(points[mine, 2].max())):
                x, y = middle[0] + reach * np.cos(around), middle[1] + reach * np.sin(around)
                rings.append(np.stack([x, y, np.full_like(x, z)], axis=1))
    return np.concatenate(rings)


def render_model(model: RawModel, view: View = _RAW_VIEW) -> bytes:
    """PNG of a raw model of any size, upright by the axis that its file declares, else z; seen from both sides.

    Raises:
        CannotDraw: there is no triangle to draw, or MuJoCo cannot read them. NoRenderer: there is no OpenGL.
    """
    stood = _stand_up([p for p in model.parts if len(p.mesh.faces)], model.up or Up.Z)
    if not stood:
        raise CannotDraw("there is no triangle to draw")
    spec = mujoco.MjSpec()
    many = sum(len(p.mesh.faces) for p in stood) > _MANY_FACES
    for i, part in enumerate(stood):
        _add(spec, part.replace(mesh=_coarsened(part.mesh)) if many else part, i)
    add_highlights(spec)
    studio.add_studio(spec, view.size_px)
    try:
        made = spec.compile()
    except ValueError as error:
        raise CannotDraw(str(error).replace("\n", " ")) from error
    data = mujoco.MjData(made)
    mujoco.mj_forward(made, data)
    points = studio.place_floor(made, data)
    return pictures.png(studio.render(made, data, points, fit(points, view), view, both_sides=True))


def _stand_up(parts: Sequence[RawPart], up: Up) -> list[RawPart]:
    """The parts with z up, about the origin, the longest side 1 m; unused vertices do not count."""
    turn = {Up.X: [[0, -1, 0], [0, 0, -1], [1, 0, 0]], Up.Y: [[1, 0, 0], [0, 0, -1], [0, 1, 0]], Up.Z: np.eye(3)}[up]
    clouds = [p.mesh.vertices @ np.array(turn).T for p in parts]
    if not parts:
        return []
    used = np.concatenate([c[np.unique(p.mesh.faces)] for c, p in zip(clouds, parts, strict=True)])
    lower, upper = used.min(axis=0), used.max(axis=0)
    scale = 1.0 / max(float((upper - lower).max()), 1e-300)
    return [
        p.replace(mesh=p.mesh.replace(vertices=(c - (lower + upper) / 2.0) * scale, normals=None))
        for c, p in zip(clouds, parts, strict=True)
    ]


def _coarsened(mesh: Mesh) -> Mesh:
    """A mesh of 1 m, the vertices in each cell of the grid merged into their mean, with colour and uv of the first."""
    cells = np.rint(mesh.vertices * _GRID_STEPS).astype(np.int64)
    keys = (cells[:, 0] * 4 * _GRID_STEPS + cells[:, 1]) * 4 * _GRID_STEPS + cells[:, 2]
    _, first, number, count = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    vertices = mesh.vertices.copy()
    vertices[first] = np.stack([np.bincount(number, axis) for axis in vertices.T], axis=1) / count[:, None]
    faces = first[number[mesh.faces]]
    alike = np.sort(faces, axis=1)
    kept = np.unique(alike, axis=0, return_index=True)[1]
    kept = kept[(np.diff(alike[kept], axis=1) > 0).all(axis=1)]
    # Nothing is left of a thing that is smaller than a cell.
    return mesh.replace(vertices=vertices, faces=faces[kept].astype(np.int32) if len(kept) else mesh.faces[:1])


def _add(spec: Any, part: RawPart, i: int) -> None:
    """One part as a mesh, a material and a geom of the spec."""
    mesh = spec.add_mesh()
    mesh.name = f"mesh{i}"
    kept, faces = np.unique(part.mesh.faces, return_inverse=True)
    vertices = part.mesh.vertices[kept].astype(np.float32)
    spare = np.repeat(vertices[:1], max(0, _LEAST_VERTICES - len(vertices)), axis=0)
    mesh.uservert = np.concatenate([vertices, spare]).ravel()
    mesh.userface = faces.astype(np.int32).ravel()
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    pixels, uv, uv_faces = None, np.zeros((0, 2)), faces
    if part.material.base_color_texture is not None and part.mesh.uv is not None:
        pixels, uv = _opened(part.material.base_color_texture), part.mesh.uv[kept]
    elif part.mesh.colors is not None:
        pixels, uv = _palette(part.mesh)
        uv_faces = np.arange(len(uv))
    material = spec.add_material()
    material.name = f"look{i}"
    base = part.material.base_color
    # However clear it is, it can be seen.
    material.rgba = [*srgb_from_linear_array(np.array(base[:3])), max(base[3], 0.15)]
    material.metallic, material.roughness = part.material.metallic, part.material.roughness
    if pixels is not None:
        # MuJoCo's images begin at the top, ours at the lower left.
        mesh.usertexcoord = (uv * [1.0, -1.0] + [0.0, 1.0]).astype(np.float32).ravel()
        mesh.userfacetexcoord = uv_faces.astype(np.int32).ravel()
        texture = spec.add_texture()
        texture.name = f"image{i}"
        texture.type = mujoco.mjtTexture.mjTEXTURE_2D
        texture.width, texture.height, texture.nchannel = pixels.shape[1], pixels.shape[0], 3
        texture.data = pixels.tobytes()
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture.name
    geom = spec.worldbody.add_geom()
    geom.type, geom.meshname, geom.material = mujoco.mjtGeom.mjGEOM_MESH, mesh.name, material.name
    geom.group = studio.VISUAL_GROUP
    geom.contype = geom.conaffinity = 0


def _palette(mesh: Mesh) -> tuple[Pixels, Floats]:
    """An image with 2 x 2 pixels for each face, and (3 F, 2) places of the corners of the faces in it.

    OpenGL mixes the pixels as the colours of the corners mix within the face: the fourth one completes a plane.
    Faces as small as a pixel of the picture would be mixed with others, and have one colour.
    """
    assert mesh.colors is not None
    side = int(np.ceil(np.sqrt(len(mesh.faces))))
    first, second, third = (mesh.colors[mesh.faces[:, k], :3].astype(np.int16) for k in range(3))
    blocks = np.zeros((side * side, 4, 3), dtype=np.uint8)
    blocks[: len(first)] = np.clip(np.stack([first, second, third, second + third - first], axis=1), 0, 255)
    pixels = blocks.reshape(side, side, 2, 2, 3).swapaxes(1, 2).reshape(2 * side, 2 * side, 3)
    row, column = np.divmod(np.arange(len(first)), side)
    within = [[0, 0], [1, 0], [0, -1]] if len(first) < _SMALL_FACES else [[0.5, -0.5]] * 3
    corners = np.stack([2 * column, 2 * (side - row) - 1], axis=1)[:, None] + np.array(within)
    return pixels, (corners.reshape(-1, 2) + 0.5) / (2 * side)


def _opened(texture: Texture) -> Pixels:
    """(H, W, 3) pixels, first row at the top, at most 1024 on a side."""
    with Image.open(io.BytesIO(texture.png)) as source:
        picture = source.convert("RGB")
    picture.thumbnail((_LARGEST_PX, _LARGEST_PX), Image.Resampling.BOX)
    return np.asarray(picture)


@dataclass(frozen=True)
class MovingJoint:
    """A joint to be shown, with two lines under its picture; one that moves a few millimetres gets none alone."""

    joint: str
    title: str
    subtitle: str
    alone: bool = True


def joint_strip(model_xml: Path, moving: Sequence[MovingJoint], heading: str) -> bytes:
    """PNG: closed, coloured with axes, taken apart, all open, then each joint open alone. Raises as `render`."""
    model, data, _ = load_into_studio(model_xml, CELL_PX)
    before = _behind(model)
    ends = {m.joint: float(max(model.joint(m.joint).range, key=abs)) for m in moving}
    every = {name: (end if abs(end) < 3.0 else end / 8) for name, end in ends.items()}
    shots = [SheetCell("closed", f"{len(moving)} moving part{'s' * (len(moving) != 1)}", _shot(model, data, {}))]
    names = [m.joint for m in moving]
    shots.append(SheetCell("parts", "one colour each, with the axis", _painted(model, data, names)))
    shots.append(SheetCell("taken apart", "", _apart(model, data, names)))
    if sum(m.alone for m in moving) > 1:
        shots.append(SheetCell("all open", "", _shot(model, data, every)))
    for m in moving:
        if m.alone:
            pose = {m.joint: every[m.joint], **{b: ends[b] for b in before.get(m.joint, ()) if b in ends}}
            shots.append(SheetCell(m.title, m.subtitle, _shot(model, data, pose)))
    return contact_sheet(shots, heading, min(COLUMNS, len(shots)), CELL_PX)


def strip_corners(moving: Sequence[MovingJoint]) -> dict[str, tuple[int, int]]:
    """Pixel (x, y) of the upper left corner of `closed`, `parts`, `taken apart` and each joint alone on a strip."""
    alone = [m.joint for m in moving if m.alone]
    names = ["closed", "parts", "taken apart", *(["all open"] if len(alone) > 1 else []), *alone]
    return {name: cell_corner(i, min(COLUMNS, len(names)), CELL_PX) for i, name in enumerate(names)}


def _behind(model: Any) -> dict[str, tuple[str, ...]]:
    """Joint -> joints that must be open before it can move, from the texts `behind__<joint>` of the model."""
    found: dict[str, tuple[str, ...]] = {}
    for i in range(model.ntext):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, i)
        start, size = int(model.text_adr[i]), int(model.text_size[i])
        if name.startswith("behind__"):
            found[name.removeprefix("behind__")] = (bytes(model.text_data[start : start + size - 1]).decode(),)
    return found


def _stand(model: Any, data: Any, pose: Mapping[str, float]) -> Floats:
    """Put joints at values, the rest at zero; (N, 3) points of what is seen, metres."""
    data.qpos[:] = model.qpos0
    for name, value in pose.items():
        data.qpos[int(model.jnt_qposadr[model.joint(name).id])] = value
    mujoco.mj_forward(model, data)
    return studio.place_floor(model, data)


def _shot(model: Any, data: Any, pose: Mapping[str, float]) -> bytes:
    return _picture(model, data, _stand(model, data, pose))


def _picture(model: Any, data: Any, points: Floats) -> bytes:
    return pictures.png(studio.render(model, data, points, fit(points, _VIEW), _VIEW, both_sides=True))


def _apart(model: Any, data: Any, names: Sequence[str]) -> bytes:
    """Every part moved off what carries it, away from the middle of the thing."""
    points = _stand(model, data, {})
    low, high = points.min(axis=0), points.max(axis=0)
    reach = _APART * float(np.linalg.norm(high - low))
    moved: dict[int, Floats] = {}
    bodies = {int(model.jnt_bodyid[model.joint(n).id]) for n in names}
    for body in range(1, model.nbody):
        offset = moved.get(int(model.body_parentid[body]), np.zeros(3))
        geoms = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) == body]
        if body in bodies and geoms:
            middle = np.mean([data.geom_xpos[g] for g in geoms], axis=0)
            off = offset if offset.any() else (middle - (low + high) / 2) / np.maximum(high - low, 1e-9)
            side = int(np.argmax(np.abs(off)))
            offset = offset + np.eye(3)[side] * np.sign(off[side] or 1.0) * reach
        moved[body] = offset
    for g in range(model.ngeom):
        data.geom_xpos[g] += moved.get(int(model.geom_bodyid[g]), np.zeros(3))
    return _picture(model, data, studio.place_floor(model, data))


def _painted(model: Any, data: Any, names: Sequence[str]) -> bytes:
    """Picture with every part in a different colour and the axes drawn over it; the model keeps its looks."""
    kept = model.geom_matid.copy(), model.geom_rgba.copy()
    points = _stand(model, data, {})
    colour = {int(model.jnt_bodyid[model.joint(n).id]): part_color(i) for i, n in enumerate(names)}
    floor = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) == 0 and model.geom_type[g] == 0]
    for g in range(model.ngeom):
        if g in floor:
            continue
        body = int(model.geom_bodyid[g])
        while body and body not in colour:
            body = int(model.body_parentid[body])
        model.geom_matid[g], model.geom_rgba[g] = -1, [*colour.get(body, _BODY), 1.0]
    camera = fit(points, replace(_VIEW, fill=0.7))
    picture = studio.render(model, data, points, camera, _VIEW, both_sides=True)
    model.geom_matid[:], model.geom_rgba[:] = kept
    return _with_axes(picture, camera, model, data, names)


def _with_axes(picture: Pixels, camera: Camera, model: Any, data: Any, names: Sequence[str]) -> bytes:
    image = Image.fromarray(picture)
    pen = ImageDraw.Draw(image)
    font = ImageFont.load_default(12)
    extent = float(model.stat.extent)
    for i, name in enumerate(names):
        joint = model.joint(name).id
        axis, middle = np.array(data.xaxis[joint]), np.array(data.xanchor[joint])
        body = int(model.jnt_bodyid[joint])
        size = max((float(model.geom_rbound[g]) for g in range(model.ngeom) if model.geom_bodyid[g] == body), default=0)
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE:
            middle = np.array(data.xipos[body])
        axis = axis * np.sign(float(max(model.jnt_range[joint], key=abs)) or 1.0)
        half = axis * max(1.05 * size, 0.05 * extent)
        turns = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        x, y, _ = camera.project(np.array([middle - half if turns else middle, middle + half]))
        at = [((float(a) + 1) / 2 * CELL_PX, (1 - float(b)) / 2 * CELL_PX) for a, b in zip(x, y, strict=True)]
        ink = tuple(int(255 * 0.62 * c) for c in part_color(i))
        pen.line(at, fill=(255, 255, 255), width=5)
        pen.line(at, fill=ink, width=3)
        pen.ellipse((at[1][0] - 5, at[1][1] - 5, at[1][0] + 5, at[1][1] + 5), fill=ink, outline=(255, 255, 255))
        pen.text(
            (at[1][0] + 7, at[1][1] - 8), str(i), fill=_DARK, font=font, stroke_width=2, stroke_fill=(255, 255, 255)
        )
    return pictures.png(np.asarray(image))


def part_color(i: int) -> tuple[float, float, float]:
    """Red, green and blue, 0..1, of the i-th part where parts are coloured; neighbours differ well."""
    return colorsys.hsv_to_rgb((0.02 + i * 0.61803398875) % 1.0, (0.72, 0.5)[i % 2], (0.95, 0.85)[i // 2 % 2])
