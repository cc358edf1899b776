"""Build the interiors that a mesh lacks behind its fronts: cut them into the body, and add parts of kitchenware/."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from casa_assets import registry
from casa_assets.articulate.decisions import GIVEN_REASON, LENGTH_TOLERANCE_M, CavityDecision, Decisions
from casa_assets.articulate.fronts.joints import DRAWER_TRAVEL_SHARE
from casa_assets.articulate.interior.cavities import find_cavities
from casa_assets.articulate.plan import (
    ADDED_MESH_NAMES,
    AddedGeometry,
    Articulation,
    Cavity,
    Frame,
    HingeEdge,
    InteriorKind,
    PartKind,
    PartPlan,
    StorageSpace,
    slide,
    to_vec3,
)
from casa_assets.articulate.segment.cutting import CutPlane, cut_triangles
from casa_assets.articulate.segment.fragments import WeldedMesh, joined_meshes, weld_model
from casa_assets.articulate.segment.orthographic import FRONT
from casa_assets.asset.asset_builder import ROOT, AssetBuilder, JointBuilder, LinkBuilder
from casa_assets.asset.family import Supplies
from casa_assets.asset.solid import solid_mesh
from casa_assets.core.numeric import Ints
from casa_assets.errors import UnknownId
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.asset import Labels
from casa_assets.model.asset.parts import JointKind, Mesh
from casa_assets.model.record import Vec3
from casa_assets.model.source import RawModel, RawPart
from casa_assets.registry.plugins.interiors import FURNISHERS, Interior, add_drawer_box, add_walls
from casa_assets.textures.run.recipes import plain

# Finish of the walls of an interior, and of the boxes of drawers beside it.
LINER_FINISHES: Mapping[InteriorKind, str] = {
    InteriorKind.OVEN: "enamel_charcoal",
    InteriorKind.MICROWAVE: "enamel_grey",
    InteriorKind.REFRIGERATOR: "plastic_white",
    InteriorKind.DISHWASHER: "stainless_brushed",
    InteriorKind.CABINET: "melamine_white",
    InteriorKind.PLAIN: "plastic_grey",
    InteriorKind.DRAWER: "melamine_white",
}
BOX_FINISHES: Mapping[InteriorKind, str] = {
    InteriorKind.OVEN: "enamel_charcoal",
    InteriorKind.REFRIGERATOR: "plastic_white",
    InteriorKind.DISHWASHER: "stainless_brushed",
}
# Gap beside a door that stands open at a right angle, on top of the thickness by which it narrows the mouth.
DOOR_CLEARANCE_M = 0.012
# A cavity of a given size cuts the body this share of its wall thickness beyond itself, on every side.
CUT_SHARE = 0.5
# Thickness of a liner that is built into a cavity that the mesh has, as a share of its smallest side.
LINER_SHARE = 0.04
# Cut planes reach through whatever crosses a cavity, diagonals.
PLANE_EXTENT = 10.0
Box = tuple[Vec3, Vec3]


@dataclass
class _InteriorBuild:
    """The builder of interior parts, and the kind of interior of each link; lengths in metres of the frame."""

    builder: AssetBuilder
    metres: float
    interior: dict[str, InteriorKind] = field(default_factory=dict)
    trays: int = 0


def add_interiors(
    model: RawModel, placed: WeldedMesh, articulation: Articulation, category: str, decisions: Decisions, build: bool
) -> tuple[RawModel, WeldedMesh, Articulation]:
    """Give every front something that it opens onto.

    Args:
        model: its faces, part by part, are those of `placed`. articulation: its parts, with `frame.metres` set.
        category: id where it is known, else empty. build: build what is missing; else only what the decisions ask for.
    """
    found = find_cavities(placed, articulation, category)
    least_sure = registry.load_confidence().bars.front
    cavities = apply_cavity_decisions(found, articulation, placed, decisions, build, least_sure)
    spaces = []
    for r in cavities:
        in_drawer = r.interior is InteriorKind.DRAWER
        if not r.empty and not (r.built and in_drawer):  # a box that is built for a drawer brings its space
            part = r.parts[0] if in_drawer else ""
            spaces.append(StorageSpace(name=f"{r.parts[0]}_int", part=part, lower=r.lower, upper=r.upper))
    articulation = articulation.replace(cavities=cavities, spaces=tuple(spaces))
    to_build = [r for r in cavities if r.built]
    if not to_build:
        return model, placed, articulation
    holes = [hole for r in to_build if r.cut is not None for hole in (r.cut, *r.fronts)]
    model, placed, articulation = hollow_out(model, placed, articulation, holes)
    metres = articulation.frame.metres or 1.0
    registered = registry.load()
    kind = registered.category(registry.FALLBACK)
    labels = Labels(category=kind.id, classes=(kind.id,), qcode=kind.qcode)
    supplies = Supplies(finishes=plain(), labels=labels, densities=registered.densities)
    work = _InteriorBuild(AssetBuilder(supplies), metres)
    work.trays = sum(p.name.startswith("tray_") for p in articulation.parts)
    for cavity in to_build:
        articulation = _build_interior(work, cavity, articulation, placed)
    return _with_added_parts(work, model, articulation)


def _build_interior(
    work: _InteriorBuild, cavity: Cavity, articulation: Articulation, placed: WeldedMesh
) -> Articulation:
    """Build one interior; return the articulation with the joints that this changes."""
    metres, builder = work.metres, work.builder
    part = next(p for p in articulation.parts if p.name == cavity.parts[0])
    outer = _to_metres(cavity.outer[0], metres), _to_metres(cavity.outer[1], metres)
    interior = Interior(
        part.name,
        _to_metres(cavity.lower, metres),
        _to_metres(cavity.upper, metres),
        outer,
        f"{part.name}_joint",
        _door_clearance(cavity, articulation, placed),
        work.trays,
    )
    links_before = list(builder.links)
    if part.kind is PartKind.DRAWER:
        if cavity.cut is not None:
            add_walls(builder, interior, LINER_FINISHES[InteriorKind.PLAIN])
        builder.link(part.name)
        # As the first cavity that is not a drawer.
        others = (r.interior for r in articulation.cavities if r.interior is not InteriorKind.DRAWER)
        finish = BOX_FINISHES.get(next(others, InteriorKind.DRAWER), LINER_FINISHES[InteriorKind.DRAWER])
        depth = (
            add_drawer_box(builder, part.name, f"{interior.name}_int", interior.lower, interior.upper, finish) / metres
        )
        articulation = _limit_travel(articulation, part, depth)
    else:
        if cavity.wall:
            add_walls(builder, interior, LINER_FINISHES[cavity.interior])
        if cavity.furnish and cavity.interior in FURNISHERS:
            FURNISHERS[cavity.interior](builder, interior)
    work.interior.setdefault(ROOT, cavity.interior)
    for name in builder.links:
        if name not in links_before:
            work.interior[name] = cavity.interior
    work.trays += sum(n.startswith("tray_") for n in builder.links if n not in links_before)
    return articulation


def _door_clearance(cavity: Cavity, articulation: Articulation, placed: WeldedMesh) -> tuple[float, float]:
    """Return how much of the mouth open doors take at the left and at the right, metres."""
    left = right = 0.0
    for part in (p for p in articulation.parts if p.name in cavity.parts and p.joint.kind is JointKind.HINGE):
        points = placed.points[placed.faces[part.faces].reshape(-1)]
        x = float(part.joint.anchor[0])
        thickness = float(points[:, 1].max()) - float(part.joint.anchor[1])
        metres = articulation.frame.metres or 1.0
        if part.joint.edge is HingeEdge.LEFT:
            left = max(left, (x + thickness - cavity.lower[0]) * metres + DOOR_CLEARANCE_M)
        if part.joint.edge is HingeEdge.RIGHT:
            right = max(right, (cavity.upper[0] - x + thickness) * metres + DOOR_CLEARANCE_M)
    return max(left, 0.0), max(right, 0.0)


def _limit_travel(articulation: Articulation, drawer: PartPlan, depth: float) -> Articulation:
    """Limit a drawer's travel to what its box allows, unless the user gave it."""
    joint = drawer.joint
    max_travel = DRAWER_TRAVEL_SHARE * depth
    if joint.reason == GIVEN_REASON or joint.range[1] <= max_travel:
        return articulation
    limited = drawer.replace(joint=joint.replace(range=(0.0, max_travel)))
    return articulation.replace(parts=tuple(limited if p.name == drawer.name else p for p in articulation.parts))


def _with_added_parts(
    work: _InteriorBuild, model: RawModel, articulation: Articulation
) -> tuple[RawModel, WeldedMesh, Articulation]:
    """Return the model with everything that was built, as parts and faces."""
    parts, faces = list(model.parts), sum(len(p.mesh.faces) for p in model.parts)
    parts_by_name = {p.name: p for p in articulation.parts}
    added: list[AddedGeometry] = []
    for link in work.builder.links.values():
        interior = work.interior.get(link.name, InteriorKind.PLAIN)
        new_parts = _raw_parts(work, link, articulation, interior)
        count = sum(len(p.mesh.faces) for p in new_parts)
        if not count:
            continue
        new_faces = np.arange(faces, faces + count)
        parts, faces = [*parts, *new_parts], faces + count
        shapes = (tessellate(c.shape, c.pose, 16)[0] for c in link.colliders)
        clouds = tuple((cloud + np.array(link.pose.position)) / work.metres for cloud in shapes)
        name = "" if link.name == ROOT else link.name
        added.append(AddedGeometry(part=name, interior=interior, faces=new_faces, clouds=clouds))
        if name in parts_by_name:
            parts_by_name[name] = parts_by_name[name].replace(
                faces=np.concatenate([parts_by_name[name].faces, new_faces])
            )
        elif name:
            joint = next(m for m in work.builder.joints if m.child == name)
            parts_by_name[name] = _tray_part(name, new_faces, joint, link, work.metres, interior)
    spaces = []
    for region in (r for r in work.builder.regions if r.link != ROOT):
        center = np.array(region.pose.position) + np.array(work.builder.links[region.link].pose.position)
        half = np.array(region.size) / 2
        lower, upper = to_vec3((center - half) / work.metres), to_vec3((center + half) / work.metres)
        spaces.append(StorageSpace(name=region.name, part=region.link, lower=lower, upper=upper))
    model = model.replace(parts=tuple(parts))
    articulation = articulation.replace(
        parts=tuple(parts_by_name.values()), added=tuple(added), spaces=(*articulation.spaces, *spaces)
    )
    return model, weld_model(model, by_material=False).in_frame(articulation.frame), articulation


def _raw_parts(
    work: _InteriorBuild, link: LinkBuilder, articulation: Articulation, interior: InteriorKind
) -> list[RawPart]:
    """Return the visible surface of a built link, one part per finish, in file axes and units."""
    finishes: dict[str, list[Mesh]] = {}
    for i, part in enumerate(link.parts):
        tile = work.builder.supplies.finish(part.finish).tile_m
        finishes.setdefault(part.finish, []).append(solid_mesh(part.solid, tile, part.grain, f"{link.name}/{i}"))
    out = []
    for finish, meshes in finishes.items():
        points, faces, _ = joined_meshes(meshes)
        points = articulation.frame.to_file((points + np.array(link.pose.position)) / work.metres)
        mesh = Mesh(vertices=points, faces=np.concatenate(faces).astype(np.int32))
        material = work.builder.supplies.finish(finish).material
        out.append(RawPart(name=ADDED_MESH_NAMES[interior], mesh=mesh, material=material))
    return out


def _tray_part(
    name: str, rows: Ints, moved: JointBuilder, link: LinkBuilder, metres: float, interior: InteriorKind
) -> PartPlan:
    """Return the plan of a part that came with an interior: a rack or a basket that slides out."""
    anchor, travel = to_vec3(np.array(link.pose.position) / metres), max(abs(r) for r in moved.range) / metres
    return PartPlan(
        name=name,
        kind=PartKind.TRAY,
        faces=rows,
        grip=np.empty(0, dtype=np.int64),
        joint=slide((0.0, -1.0, 0.0), anchor, travel, 1.0, "built so"),
        confidence=1.0,
        reason=f"added: {interior.value}",
        added=True,
    )


def _to_metres(point: Vec3, metres: float) -> Vec3:
    """Convert a point of the frame to metres, rounded to 0.1 mm so that the last digit does not matter."""
    return to_vec3(math.floor(v * metres * 1e4 + 0.5) / 1e4 for v in point)


def apply_cavity_decisions(
    cavities: Sequence[Cavity],
    articulation: Articulation,
    mesh: WeldedMesh,
    decisions: Decisions,
    build: bool,
    least_sure: float,
) -> tuple[Cavity, ...]:
    """Return the cavities with the user's decisions applied.

    Args:
        mesh: in the frame. build: whether what is missing is built where nothing is stated.
        least_sure: behind a front whose confidence is less, nothing is built where nothing is stated.
    Raises:
        UnknownId: a cavity is named after a part that closes none.
    """
    names = [r.parts[0] for r in cavities]
    for name in decisions.cavities:
        if name not in names:
            raise UnknownId("cavity", name, names)
    out = []
    for cavity in cavities:
        decision = decisions.cavities.get(cavity.parts[0])
        cavity = _with_decision(cavity, decision, articulation, mesh) if decision is not None else cavity
        is_built = build if decision is None or decision.build is None else decision.build
        if not cavity.built:
            out.append(cavity)
        elif not is_built:
            out.append(cavity.replace(built=False, empty=True))
        else:
            front = min((p for p in articulation.parts if p.name in cavity.parts), key=lambda p: p.confidence)
            if (decision is None or decision.build is None) and front.confidence < least_sure:
                reason = f"not built: {front.name} is {front.confidence:.0%} sure"
                cavity = cavity.replace(built=False, empty=True, in_doubt=True, reason=reason)
            out.append(cavity)
    return tuple(out)


def _with_decision(cavity: Cavity, decision: CavityDecision, articulation: Articulation, mesh: WeldedMesh) -> Cavity:
    changed = cavity
    if decision.build and not cavity.built:
        lower, upper = np.array(cavity.lower), np.array(cavity.upper)
        wall = LINER_SHARE * float((upper - lower).min())
        inner = np.array([lower[0] + wall, lower[1], lower[2] + wall]), upper - wall
        changed = cavity.replace(
            lower=to_vec3(inner[0]),
            upper=to_vec3(inner[1]),
            wall=wall,
            built=True,
            furnish=False,
            confidence=1.0,
            reason=GIVEN_REASON,
        )
    if (
        decision.interior is not None
        and decision.interior is not cavity.interior
        and cavity.interior is not InteriorKind.DRAWER
    ):
        changed = changed.replace(interior=decision.interior, confidence=1.0, reason=GIVEN_REASON)
    if decision.furnish is not None and decision.furnish is not cavity.furnish:
        changed = changed.replace(furnish=decision.furnish, confidence=1.0, reason=GIVEN_REASON)
    if decision.box_m is not None:
        changed = _with_box(changed, decision.box_m, articulation, mesh)
    return changed


def _with_box(cavity: Cavity, box: tuple[Vec3, Vec3], articulation: Articulation, mesh: WeldedMesh) -> Cavity:
    """Return a cavity between other corners, with walls as thick as before."""
    metres = articulation.frame.metres or 1.0
    corners = np.array(box) / metres + mesh.footprint_center
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    if float(np.abs(np.array([lower - cavity.lower, upper - cavity.upper])).max()) * metres <= LENGTH_TOLERANCE_M:
        return cavity
    grown = np.array(cavity.lower) - np.array(cavity.outer[0]), np.array(cavity.outer[1]) - np.array(cavity.upper)
    a, b = lower - np.maximum(grown[0], 0.0), upper + np.maximum(grown[1], 0.0)
    cut = cavity.cut
    if cut is not None:
        start = lower - CUT_SHARE * np.maximum(grown[0], 0.0)
        start[1] = cut[0][1]
        cut = (to_vec3(start), to_vec3(upper + CUT_SHARE * np.maximum(grown[1], 0.0)))
    return cavity.replace(
        lower=to_vec3(lower),
        upper=to_vec3(upper),
        outer=(to_vec3(a), to_vec3(b)),
        cut=cut,
        confidence=1.0,
        reason=GIVEN_REASON,
    )


def hollow_out(
    model: RawModel, placed: WeldedMesh, articulation: Articulation, holes: Sequence[Box]
) -> tuple[RawModel, WeldedMesh, Articulation]:
    """Remove all of the body that lies in some boxes of the frame.

    Args:
        model: its faces, part by part, are those of `placed`.
    """
    if not holes:
        return model, placed, articulation
    body = np.ones(len(placed.faces), dtype=bool)
    for part in articulation.parts:
        body[part.faces] = False
    parts, parents = [], []
    start = 0
    for raw in model.parts:
        count = len(raw.mesh.faces)
        mesh, parent = _carved(raw.mesh, np.flatnonzero(body[start : start + count]), articulation.frame, holes)
        if len(parent):
            parts.append(raw.replace(mesh=mesh))
            parents.append(parent + start)
        start += count
    model = model.replace(parts=tuple(parts))
    kept = np.concatenate(parents)
    hollow = weld_model(model, by_material=False).in_frame(articulation.frame)
    return model, hollow, _renumbered(articulation, kept, len(placed.faces))


def _carved(mesh: Mesh, rows: Ints, frame: Frame, holes: Sequence[Box]) -> tuple[Mesh, Ints]:
    """Return a mesh without what lies in the boxes, and the face that each of its faces was part of."""
    parent = np.arange(len(mesh.faces))
    free = np.zeros(len(mesh.faces), dtype=bool)
    free[rows] = True
    for lower, upper in ((np.array(a), np.array(b)) for a, b in holes):
        place = (mesh.vertices - np.array(frame.origin)) @ frame.rotation.T * frame.scale
        corners = place[mesh.faces]
        near = free & ((corners.min(axis=1) < upper) & (corners.max(axis=1) > lower)).all(axis=1)
        if not near.any():
            continue
        least, most = np.full(3, -PLANE_EXTENT), np.full(3, PLANE_EXTENT)
        # A cut plane on the front counts right, up and depth: x, z and y.
        done = cut_triangles(
            place,
            mesh.faces[near].astype(np.int64),
            [
                CutPlane(FRONT, k, float(end[axis]), least, most)
                for k, axis in ((0, 0), (1, 2), (2, 1))
                for end in (lower, upper)
            ],
        )
        middle = done.interpolate(place)[done.faces].mean(axis=1)
        out = ~((middle > lower) & (middle < upper)).all(axis=1)
        faces = np.concatenate([mesh.faces[~near].astype(np.int64), done.faces[out]])
        mesh = done.interpolate_mesh(mesh, faces)
        cut = np.flatnonzero(near)[done.parent[out]]
        parent, free = np.concatenate([parent[~near], parent[cut]]), np.concatenate([free[~near], free[cut]])
    return mesh, parent


def _renumbered(articulation: Articulation, kept: Ints, count: int) -> Articulation:
    """Return the parts over the remaining faces; `kept` is the old index of each."""
    place = np.full(count, -1, dtype=np.int64)
    place[kept] = np.arange(len(kept))
    parts = tuple(p.replace(faces=place[p.faces], grip=place[p.grip]) for p in articulation.parts)
    return articulation.replace(parts=parts)
