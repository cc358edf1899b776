"""Build the asset of an articulated mesh: one link per part with visuals, colliders, inertia and joint."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.build_colliders import build_colliders, part_label
from casa_assets.articulate.plan import (
    ADDED_MESH_NAMES,
    Articulation,
    PartKind,
    PartPlan,
    StorageSpace,
    round7,
    round7_vec3,
)
from casa_assets.articulate.segment.fragments import WeldedMesh, joined_meshes
from casa_assets.core import hand_dynamics
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.mesh.surface import inside_out_faces, merge_rows, shell_moments, weld, with_normals
from casa_assets.model.asset.asset import (
    UNFOUND_PARTS,
    Asset,
    Base,
    Collider,
    Drive,
    Exclusion,
    Guess,
    Inertial,
    Joint,
    JointKind,
    Labels,
    Link,
    Provenance,
    State,
    Visual,
)
from casa_assets.model.asset.material import Substance
from casa_assets.model.asset.parts import Mesh, Region
from casa_assets.model.pose import Pose
from casa_assets.model.registry.category import Category
from casa_assets.model.source import RawModel

# Two faces over the same three points fight for each pixel in renderers that draw backs, and shade each other's
# vertices. Both sides stay, since it is not known for every sheet which of them is visible; the second is drawn a hair
# off the first, towards the side that it faces, so that each hides the other from its own side.
# Distance of the two sides of a sheet, metres: more than depth images of a room resolve, less than is seen. A choice.
SHEET_GAP_M = 0.0002
ROOT = "object"
# Thickness of the sheet that inertia is computed with, by the longest side of a link: less is lost in rounding.
MIN_SHEET_SHARE = 0.002
# The most that this is, metres: of a sheet as thick as the thinnest collision shape (MIN_THICKNESS_M of link_shapes)
# mass deviates by this times the square root of 1/2 from the middle (AST008).
MAX_SHEET_M = 0.0008
# MuJoCo loads no mesh of fewer vertices: a lone triangle is left out.
MIN_VERTICES = 4
# The most that a link weighs for the volume of its collision shapes, kg/m^3: sheets of a small thing would get the mass
# of a large one. Ref: CRC Handbook of Chemistry and Physics, steel.
MAX_DENSITY_KG_M3 = 7850.0
# Sheets that stand for a hollow body enclose little: where shapes of steel are lighter than any thing of the kind,
# their density may be this many times that of steel, which is what AST003 lets pass.
MAX_SHEET_DENSITY_FACTOR = 2.4
# Weight of the body per area over that of moving parts, since it carries motors, frames and insulation. A choice.
BODY_WEIGHT_FACTOR = 2.0
# Force that starts a part; all others start as a door does.
STARTS_N = {
    PartKind.KNOB: hand_dynamics.KNOB_START_N,
    PartKind.LEVER: hand_dynamics.TAP_START_N,
    PartKind.SPOUT: hand_dynamics.TAP_START_N,
    PartKind.TRAY: hand_dynamics.TRAY_START_N,
}
# A door whose weight turns it by less than this torque needs no spring.
MIN_SPRING_TORQUE_NM = 0.05
# Parts that fingers take at the rim.
RIM_GRIPPED_KINDS = frozenset({PartKind.KNOB})
# Shortest travel that friction is computed for, rad or m.
MIN_TRAVEL = 1e-4


def drop_empty_links(articulation: Articulation, mesh: WeldedMesh) -> Articulation:
    """Return the articulation without parts that have no area, and with a body that has some.

    A face that two parts claim belongs to the later one. A part loses all faces if others take them, or if cuts along
    its border leave it without any. If all faces belong to parts, the largest part on the body becomes the body. Parts
    carried by a dropped part are then carried by the parent of that part.

    Args:
        mesh: in the frame; the faces of the parts are those of this mesh.
    """
    owner = articulation.face_owner(len(mesh.faces))
    parts: tuple[PartPlan, ...] = ()
    for i, part in enumerate(articulation.parts):
        own = np.flatnonzero(owner == i)
        is_whole = len(own) == len(np.unique(part.faces))
        parts += (part if is_whole else part.replace(faces=own, grip=np.intersect1d(part.grip, own)),)
    area = {part.name: float(mesh.areas[part.faces].sum()) for part in parts}
    parts = _without(parts, {name for name, share in area.items() if share <= 0.0})
    if parts and float(mesh.areas[owner < 0].sum()) <= 0.0:
        largest = max((p for p in parts if not p.parent), key=lambda p: area[p.name])
        parts = _without(parts, {largest.name})
    return articulation.replace(parts=parts)


def _without(parts: tuple[PartPlan, ...], names: set[str]) -> tuple[PartPlan, ...]:
    """Return parts without some of them; their children hang on the nearest part that is left, else on the body."""
    carrier = {part.name: part.parent for part in parts}

    def kept_carrier(name: str) -> str:
        while name in names:
            name = carrier[name]
        return name

    return tuple(p.replace(parent=kept_carrier(p.parent)) for p in parts if p.name not in names)


def drawn_faces(faces: Ints) -> tuple[Mask, Mask]:
    """Return which faces of a link are drawn, of those on the same three points the first of each side.

    Args:
        faces: (F, 3) welded, of the link alone, all with some area.
    Returns:
        (F,) those that are drawn where they are, and (F,) second sides of sheets, drawn SHEET_GAP_M along their
        normals; what is in neither is a copy of another face.
    """
    rows = np.arange(len(faces))
    if not len(faces):
        return np.zeros(0, dtype=bool), np.zeros(0, dtype=bool)
    _, triangle = merge_rows(np.sort(faces, axis=1).astype(np.float64))
    start = np.argmin(faces, axis=1)
    turns_left = faces[rows, (start + 1) % 3] < faces[rows, (start + 2) % 3]
    is_first = _is_first(triangle)
    return is_first, _is_first(2 * triangle + turns_left) & ~is_first


def corner_directions(faces: Ints, normals: Floats) -> Floats:
    """Return (F, 3, 3) how far each corner goes so that all faces at it move by 1 along their normals, and stay joined.

    At sharp edges it goes no farther than twice that.

    Args:
        faces: (F, 3). normals: (F, 3) unit.
    """
    used, corner = np.unique(faces, return_inverse=True)
    corner = corner.reshape(-1)
    mean = np.zeros((len(used), 3))
    np.add.at(mean, corner, np.repeat(normals, 3, axis=0))
    mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12)
    least = np.ones(len(used))
    np.minimum.at(least, corner, np.einsum("ij,ij->i", mean[corner], np.repeat(normals, 3, axis=0)))
    return (mean / np.maximum(least, 0.5)[:, None])[corner].reshape(-1, 3, 3)


def _is_first(group: Ints) -> Mask:
    _, first = np.unique(group, return_index=True)
    found = np.zeros(len(group), dtype=bool)
    found[first] = True
    return found


@dataclass(frozen=True)
class AssetSpec:
    """Properties of an asset besides its geometry.

    Attributes:
        asset_id: of the result. metres: length of the diagonal.
        category, classes, substance: what the registry says of its kind. provenance: of the source.
        refit: links whose collision shapes are fitted to the link as a whole, and are never cut.
    """

    asset_id: str
    metres: float
    category: Category
    classes: tuple[str, ...]
    substance: Substance
    provenance: Provenance
    refit: frozenset[str] = frozenset()


def assemble(model: RawModel, mesh: WeldedMesh, articulation: Articulation, spec: AssetSpec) -> Asset:
    """Build the articulated asset.

    Args:
        model: as read; its faces, part by part, are those of `mesh`.
        mesh: in the frame, diagonal 1.
    """
    place = _Place(mesh, spec.metres)
    owner = articulation.face_owner(len(mesh.faces))
    names = [ROOT, *(p.name for p in articulation.parts)]
    anchors = [np.zeros(3), *(place.point(np.array(p.joint.anchor)) for p in articulation.parts)]
    refit = frozenset(map(names.index, spec.refit))
    shapes, blocking = build_colliders(place.points, mesh, articulation, spec.substance.id, refit)
    areas = np.array([float(mesh.areas[owner == i - 1].sum()) for i in range(len(names))])
    weights = _weights(spec, areas, shapes)
    links = []
    for i, name in enumerate(names):
        rows = np.flatnonzero(owner == i - 1)
        parent = None if i == 0 else (articulation.parts[i - 1].parent or ROOT)
        at = anchors[i] - (np.zeros(3) if parent is None else anchors[names.index(parent)])
        links.append(
            Link(
                name=name,
                parent=parent,
                pose=Pose(position=round7_vec3(at)),
                inertial=_inertial(place.points - anchors[i], mesh.faces[rows], float(weights[i])),
                visuals=_visuals(model, place, owner == i - 1, articulation.parts[i - 1] if i else None, anchors[i]),
                colliders=shapes[i],
            )
        )
    joints = tuple(
        build_joint(part, spec.metres, link, behind, names)
        for part, link, behind in zip(articulation.parts, links[1:], blocking, strict=True)
    )
    return Asset(
        id=spec.asset_id,
        base=Base.FIXED if spec.category.fixed else Base.FREE,
        links=_parents_first(links),
        joints=joints,
        regions=tuple(_region(s, place, anchors[names.index(s.part) if s.part else 0]) for s in articulation.spaces),
        states=tuple(s for p in articulation.parts for s in open_closed_states(p)),
        exclusions=tuple(Exclusion(first=ROOT, second=p.name) for p in articulation.parts),
        materials=tuple(
            p.material.replace(id=f"look_{i:03d}", substance=spec.substance.id) for i, p in enumerate(model.parts)
        ),
        substances=(spec.substance,),
        labels=Labels(category=spec.category.id, classes=spec.classes, qcode=spec.category.qcode),
        provenance=spec.provenance.replace(guesses=(*spec.provenance.guesses, *_guesses(articulation))),
    )


class _Place:
    """Converts points of the frame to metres: the origin is the middle of the footprint, on the ground."""

    def __init__(self, mesh: WeldedMesh, metres: float) -> None:
        self.shift = -mesh.footprint_center * metres
        self.metres = metres
        self.points = self.point(mesh.points)
        self.mesh = mesh

    def point(self, points: Floats) -> Floats:
        """Convert points of the frame to the asset frame, metres."""
        return points * self.metres + self.shift


def _region(space: StorageSpace, place: _Place, anchor: Floats) -> Region:
    lower, upper = place.point(np.array([space.lower, space.upper])) - anchor
    pose = Pose(position=round7_vec3((lower + upper) / 2))
    return Region(
        name=space.name, link=space.part or ROOT, pose=pose, size=round7_vec3(np.maximum(upper - lower, 1e-3))
    )


def _visuals(model: RawModel, place: _Place, own: Mask, part: PartPlan | None, anchor: Floats) -> tuple[Visual, ...]:
    """Return the visuals of a link: one mesh per material of the file, with handles as separate meshes."""
    name, label = (ROOT, None) if part is None else (part.name, part_label(part.kind))
    held = np.zeros(len(own), dtype=bool)
    if part is not None and len(part.grip) < len(part.faces):
        held[part.grip] = True
    rows = np.flatnonzero(own & (place.mesh.areas > 0))
    front, second = np.zeros(len(own), dtype=bool), np.zeros(len(own), dtype=bool)
    front[rows], second[rows] = drawn_faces(place.mesh.faces[rows])
    out: list[Visual] = []
    meshes: list[Mesh] = []
    start = 0
    for i, raw in enumerate(model.parts):
        span = slice(start, start + len(raw.mesh.faces))
        grip = held[span]
        for gap in (0.0, SHEET_GAP_M):
            alive = (second if gap else front)[span]
            for chosen, mark in ((np.flatnonzero(alive & ~grip), label), (np.flatnonzero(alive & grip), "handle")):
                corners = place.points[place.mesh.faces[start + chosen]] - anchor
                if gap:
                    faces = raw.mesh.faces[chosen].astype(np.int64)
                    corners = corners + gap * corner_directions(faces, place.mesh.normals[start + chosen])
                mesh = _cut(raw.mesh, chosen, corners) if len(chosen) else None
                if mesh is not None and len(mesh.vertices) >= MIN_VERTICES:
                    where = f"{name}_{raw.name if raw.name in ADDED_MESH_NAMES.values() else 'visual'}_{len(out):03d}"
                    out.append(Visual(name=where, mesh=mesh, material=f"look_{i:03d}", label=mark))
                    meshes.append(mesh)
        start = span.stop
    return tuple(v.replace(mesh=_shaded(m)) for v, m in zip(out, _turned_outwards(meshes), strict=True))


def _turned_outwards(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Return the meshes of a link with closed parts that wind inwards turned: renderers draw no backs.

    Pieces that share no vertex are looked at one by one, since boards that touch bound no volume once they are welded;
    then what is welded, for files whose faces share no vertices.
    """
    if not meshes:
        return []
    vertices, each, starts = joined_meshes(meshes)
    faces = np.concatenate(each)
    points, welded = weld(vertices)
    faces = _flipped(faces, inside_out_faces(vertices, faces))
    faces = _flipped(faces, inside_out_faces(points, welded[faces]))
    ends = np.cumsum([len(m.faces) for m in meshes])[:-1]
    return [m.replace(faces=f - s) for m, f, s in zip(meshes, np.split(faces, ends), starts, strict=True)]


def _flipped(faces: Ints, rows: Mask) -> Ints:
    return np.where(rows[:, None], faces[:, ::-1], faces)


def _shaded(mesh: Mesh) -> Mesh:
    """Return a mesh with normals, all values rounded to single precision."""
    if not len(mesh.faces):
        return mesh
    shaded = with_normals(mesh)
    return shaded if shaded.normals is None else shaded.replace(normals=_single(shaded.normals))


def _cut(mesh: Mesh, rows: Ints, corners: Floats) -> Mesh:
    """Return some faces of a mesh at new places, with their texture coordinates; float32 values throughout."""
    faces = mesh.faces[rows].astype(np.int64)
    used, local = np.unique(faces, return_inverse=True)
    vertices = np.zeros((len(used), 3))
    vertices[local.reshape(-1)] = corners.reshape(-1, 3)
    vertices = _single(vertices)
    shape = vertices[local.reshape(-1, 3)]
    alive = np.linalg.norm(np.cross(shape[:, 1] - shape[:, 0], shape[:, 2] - shape[:, 0]), axis=1) > 1e-14
    uv = None if mesh.uv is None else _single(mesh.uv[used])
    return Mesh(vertices=vertices, faces=local.reshape(-1, 3)[alive], uv=uv)


def _single(values: Floats) -> Floats:
    return values.astype(np.float32).astype(np.float64)


def _weights(spec: AssetSpec, areas: Floats, shapes: Sequence[Sequence[Collider]]) -> Floats:
    """Return the (N,) masses of links in kg: a total divided in proportion to their areas, up to each one's maximum.

    Mass above the maximum of one link goes to the others, as far as their own maxima allow.
    """
    areas[0] *= BODY_WEIGHT_FACTOR
    span = spec.category.mass_kg
    volumes = [sum(hull_volume(tessellate(c.shape, c.pose)[0]) for c in own) for own in shapes]
    # Of steel throughout; a link without shapes may weigh anything.
    heaviest = np.array([MAX_DENSITY_KG_M3 * v if own else math.inf for v, own in zip(volumes, shapes, strict=True)])
    needed = 1.01 * span.low / max(float(heaviest.sum()), 1e-9)
    heaviest *= needed if 1.0 < needed <= MAX_SHEET_DENSITY_FACTOR else 1.0
    usual = span.typical * (spec.metres / (1.3 * spec.category.longest_m.typical)) ** 3
    total = float(np.clip(usual, span.low, span.high))
    shares = np.maximum(areas / max(float(areas.sum()), 1e-12), 1e-4)
    found: Floats = np.minimum(total * shares, heaviest)
    for _ in range(len(areas)):
        missing = total - float(found.sum())
        room = heaviest - found > 1e-9
        if missing <= 1e-9 or not room.any():
            break
        found = np.minimum(found + missing * np.where(room, shares, 0.0) / float(shares[room].sum()), heaviest)
    return found


def _inertial(points: Floats, faces: Ints, mass: float) -> Inertial:
    """Return the mass properties of a link as a sheet of even thickness over its surface."""
    area, center, inertia = shell_moments(points, faces)
    tensor = inertia / max(area, 1e-12) * mass
    longest = float(np.ptp(points[faces].reshape(-1, 3), axis=0).max())
    # What is as thick as that by itself, such as two sheets back to back, is spread no farther.
    spread = np.linalg.eigvalsh(np.eye(3) * np.trace(tensor) / 2 - tensor)[0] / mass
    tensor = tensor + np.eye(3) * mass * max(0.0, min(MIN_SHEET_SHARE * longest, MAX_SHEET_M) ** 2 - 2 * spread)
    xx, yy, zz, xy, xz, yz = (round7(tensor[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return Inertial(mass=round7(mass), center_of_mass=round7_vec3(center), inertia=(xx, yy, zz, xy, xz, yz))


def _guesses(articulation: Articulation) -> tuple[Guess, ...]:
    frame = articulation.frame
    out = [Guess(subject="frame", value="up and front", confidence=frame.confidence, reason=frame.reason)]
    for p in articulation.parts:
        out.append(Guess(subject=p.name, value=p.kind.value, confidence=p.confidence, reason=p.full_reason))
    if articulation.signs:
        reason = "; ".join(articulation.signs)
        out.append(Guess(subject=UNFOUND_PARTS, value="none was found", confidence=0.0, reason=reason))
    for cavity in articulation.cavities:
        if cavity.built:
            subject, value = f"{cavity.parts[0]}_cavity", f"added: {cavity.interior.value}"
            out.append(Guess(subject=subject, value=value, confidence=cavity.confidence, reason=cavity.reason))
    return tuple(out)


def _parents_first(links: list[Link]) -> tuple[Link, ...]:
    by_name = {link.name: link for link in links}

    def depth(link: Link) -> int:
        return 0 if link.parent is None else 1 + depth(by_name[link.parent])

    return tuple(sorted(links, key=depth))


def build_joint(part: PartPlan, metres: float, link: Link, behind: int | None, names: Sequence[str]) -> Joint:
    """Return the joint of a part in the child's frame, with friction and damping that fit the hand that moves it.

    Args:
        metres: length of the diagonal, in which the ranges of slides are given. link: the one that moves.
        behind: index of the part that must be open first, or None. names: of all links, the body first.
    """
    slides = part.joint.kind is JointKind.SLIDE
    lower, upper = (r * metres if slides else r for r in part.joint.range)
    way = upper - lower
    axis = np.array(part.joint.axis)
    grip = next((c for c in link.colliders if c.label == "handle"), link.colliders[0] if link.colliders else None)
    arm = 1.0 if slides else _arm(link, grip, axis, part.kind in RIM_GRIPPED_KINDS)
    inertia = link.inertial.mass if slides else _about(link, axis)
    spring = None if slides else _balance(link, axis, upper)
    feel = hand_dynamics.feel_against(
        spring, inertia, arm, max(way, MIN_TRAVEL), STARTS_N.get(part.kind, hand_dynamics.START_N)
    )
    if part.kind is PartKind.BUTTON:
        spring = hand_dynamics.press(max(way, MIN_TRAVEL), hand_dynamics.KEY_FULL_N, hand_dynamics.KEY_PRELOAD_N)
        feel = hand_dynamics.KEY
    return Joint(
        name=f"{part.name}_joint",
        child=part.name,
        kind=part.joint.kind,
        axis=part.joint.axis,
        range=(round7(lower), round7(upper)),
        damping=feel.damping,
        frictionloss=feel.frictionloss,
        armature=feel.armature,
        drive=None if spring is None else Drive(stiffness=spring.stiffness, damping=0.0, target=spring.rest),
        grip=None if grip is None else grip.name,
        behind=None if behind is None else f"{names[behind + 1]}_joint",
    )


def _balance(link: Link, axis: Floats, far: float) -> hand_dynamics.Spring | None:
    """Return the spring of a door that would otherwise fall open, None if it would not."""
    center = np.array(link.inertial.center_of_mass)
    turned = center * math.cos(far) + np.cross(axis, center) * math.sin(far)
    turned = turned + axis * float(axis @ center) * (1 - math.cos(far))
    falls = float(np.cross(turned, np.array([0.0, 0.0, -9.81 * link.inertial.mass])) @ axis)
    return None if falls <= MIN_SPRING_TORQUE_NM else hand_dynamics.carry(falls, far)


def _arm(link: Link, grip: Collider | None, axis: Floats, rim: bool) -> float:
    """Return the distance from the axis to the hand, metres: to the handle, or to the rim of what fingers turn."""
    if grip is None:
        return 0.01
    points = tessellate(grip.shape, grip.pose)[0] if rim else np.array([grip.pose.position])
    off = points - np.outer(points @ axis, axis)
    return max(0.005, float(np.linalg.norm(off, axis=1).max()))


def _about(link: Link, axis: Floats) -> float:
    """Return the inertia of a link about an axis through its origin, kg*m^2."""
    center = np.array(link.inertial.center_of_mass)
    off = center - axis * float(center @ axis)
    return float(axis @ link.inertial.tensor @ axis) + link.inertial.mass * float(off @ off)


def open_closed_states(part: PartPlan) -> tuple[State, ...]:
    """Return the closed and open states of a front. Ref: robocasa v1.0, is_closed 0.005, is_open 0.9."""
    if part.kind not in (PartKind.DOOR, PartKind.DRAWER, PartKind.LID):
        return ()
    joint = f"{part.name}_joint"
    return (
        State(name=f"{joint}_closed", joint=joint, value="closed", interval=(0.0, 0.005)),
        State(name=f"{joint}_open", joint=joint, value="open", interval=(0.9, 1.0)),
    )
