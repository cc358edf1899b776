"""Turn an AssetBuilder into an Asset: meshes, masses, friction of joints, origin under the middle of the footprint."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from casa_assets.core import hand_dynamics
from casa_assets.core.rounding import significant
from casa_assets.families.family import Params
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder, JointBuilder, LinkBuilder, VisualPart
from casa_assets.families.kit.mass_properties import combine_masses
from casa_assets.families.kit.quantize import quantize
from casa_assets.families.kit.solids.skin import solid_mesh
from casa_assets.model.asset.asset import Asset, Drive, Inertial, Joint, JointKind, Link, Region, Visual
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.provenance import Provenance
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3


def assemble(builder: AssetBuilder, family: str, params: Params) -> Asset:
    """Return the finished Asset; its id is the family and the first 10 hex digits of the digest of its parameters."""
    inertials = {name: _inertial(piece) for name, piece in builder.links.items()}
    joints = tuple(_joint(builder, m, inertials) for m in builder.joints)
    visuals = {name: _visuals(builder, piece) for name, piece in builder.links.items()}
    links = tuple(
        Link(
            name=p.name,
            parent=p.parent,
            pose=p.pose,
            inertial=inertials[p.name],
            visuals=visuals[p.name],
            colliders=tuple(p.colliders),
        )
        for p in _ordered(builder)
    )
    materials = _materials(builder, links)
    made = Asset(
        id=f"{family}_{params.digest[:10]}",
        base=builder.base,
        links=links,
        joints=joints,
        sites=tuple(builder.sites),
        regions=tuple(builder.regions),
        states=tuple(builder.states),
        keyframes=tuple(builder.keyframes),
        behavior=builder.behavior,
        contract=builder.contract,
        materials=materials,
        substances=_substances(builder, links),
        labels=builder.supplies.labels,
        provenance=Provenance(
            source="family",
            path=family,
            sha256=params.digest,
            title=family.replace("_", " "),
            licence="Apache-2.0",
            generator="casa-assets families",
        ),
    )
    return add_main_region(quantize(center_footprint(made)))


def _ordered(builder: AssetBuilder) -> list[LinkBuilder]:
    """Links with parents before children, else in the order they were added."""
    out: list[LinkBuilder] = []
    left = list(builder.links.values())
    while left:
        ready = [p for p in left if p.parent is None or any(o.name == p.parent for o in out)]
        if not ready:
            raise ValueError(f"link {left[0].name!r}: there is no link {left[0].parent!r}")
        out += ready
        left = [p for p in left if p not in ready]
    return out


def _visuals(builder: AssetBuilder, piece: LinkBuilder) -> tuple[Visual, ...]:
    groups: dict[tuple[str, str | None, str | None], list[VisualPart]] = {}
    for part in piece.parts:
        groups.setdefault((part.finish, part.label, part.name), []).append(part)
    out = []
    for (finish, label, name), parts in groups.items():
        tile = builder.supplies.finish(finish).tile_m
        stem = name or f"{piece.name}_{label or 'body'}_{finish}"
        meshes = []
        for i, part in enumerate(parts):
            meshes.append(solid_mesh(part.solid, tile, part.grain, f"{stem}/{i}"))
        out.append(Visual(name=f"{stem}_visual", mesh=_merged(meshes), material=finish, label=label))
    return tuple(out)


def _materials(builder: AssetBuilder, links: Sequence[Link]) -> tuple[Material, ...]:
    used = sorted({v.material for k in links for v in k.visuals})
    return tuple(builder.supplies.finish(name).material for name in used)


def _substances(builder: AssetBuilder, links: Sequence[Link]) -> tuple[Substance, ...]:
    used = {c.substance for k in links for c in k.colliders}
    known = {f.substance.id: f.substance for f in builder.supplies.finishes.values()}
    return tuple(known[name] for name in sorted(used))


def _joint(builder: AssetBuilder, moved: JointBuilder, inertials: dict[str, Inertial]) -> Joint:
    lever = _lever(builder, moved) if moved.lever is None else moved.lever
    way = moved.range[1] - moved.range[0]
    inertia = _resistance(builder, moved, inertials)
    found = moved.feel or hand_dynamics.feel_against(moved.spring, inertia, lever, way, moved.start_n, moved.push_n)
    drive = None
    if moved.spring:
        drive = Drive(stiffness=moved.spring.stiffness, damping=0.0, target=moved.spring.rest)
    return Joint(
        name=moved.name,
        child=moved.child,
        kind=moved.kind,
        axis=moved.axis,
        anchor=moved.anchor,
        range=moved.range,
        damping=found.damping,
        frictionloss=found.frictionloss,
        armature=found.armature,
        drive=drive,
        grip=moved.grip,
        behind=moved.behind,
    )


def _lever(builder: AssetBuilder, moved: JointBuilder) -> float:
    """Distance from the hinge's axis to the middle of the grip, metres."""
    grips = [c for c in builder.links[moved.child].colliders if c.name == moved.grip]
    if not grips:
        raise ValueError(f"joint {moved.name!r}: link {moved.child!r} has no collider {moved.grip!r}")
    arm = np.array(grips[0].pose.position) - np.array(moved.anchor)
    axis = np.array(moved.axis)
    return max(0.01, float(np.linalg.norm(arm - axis * float(arm @ axis) / float(axis @ axis))))


def _resistance(builder: AssetBuilder, moved: JointBuilder, inertials: dict[str, Inertial]) -> float:
    """Inertia of everything a joint moves: kg*m^2 about a hinge's axis, or kg along a slide."""
    carried = _carried(builder, moved.child, Pose())
    if moved.kind is JointKind.SLIDE:
        return sum(inertials[name].mass for name, _ in carried)
    axis = np.array(moved.axis) / np.linalg.norm(moved.axis)
    total = 0.0
    for name, pose in carried:
        body = inertials[name]
        arm = pose.apply(np.array([body.center_of_mass]))[0] - np.array(moved.anchor)
        turned = pose.rotation @ body.tensor @ pose.rotation.T
        off = arm - axis * float(arm @ axis)
        total += float(axis @ turned @ axis) + body.mass * float(off @ off)
    return total


def _carried(builder: AssetBuilder, name: str, pose: Pose) -> list[tuple[str, Pose]]:
    """A link and its descendants, each with its pose in the frame of the first."""
    out = [(name, pose)]
    for piece in builder.links.values():
        if piece.parent == name:
            out += _carried(builder, piece.name, pose @ piece.pose)
    return out


def add_main_region(asset: Asset) -> Asset:
    """Add a region `main`, the bounding box of the asset, unless there is one or the asset has no runtime contract."""
    if asset.contract is None or any(region.name == "main" for region in asset.regions):
        return asset
    low, high = asset.bounds
    x, y, z = (float(v) for v in (low + high) / 2)
    a, b, c = (float(v) for v in high - low)
    outside = Region(name="main", pose=Pose(position=(x, y, z)), size=(a, b, c))
    return asset.replace(regions=(*asset.regions, outside))


def center_footprint(asset: Asset) -> Asset:
    """The asset moved so that the middle of its footprint is the origin, on the ground, joints at zero."""
    low, high = asset.bounds
    x, y, z = (float(np.float32(v)) for v in (-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]))
    shift = Pose(position=(x, y, z))
    root = asset.root
    moved = root.replace(
        inertial=root.inertial.replace(center_of_mass=_point(shift, root.inertial.center_of_mass)),
        visuals=tuple(v.replace(mesh=_shifted(v.mesh, (x, y, z))) for v in root.visuals),
        colliders=tuple(c.replace(pose=shift @ c.pose) for c in root.colliders),
    )
    others = tuple(k.replace(pose=shift @ k.pose) if k.parent == ROOT else k for k in asset.links[1:])
    return asset.replace(
        links=(moved, *others),
        sites=tuple(s.replace(pose=shift @ s.pose) if s.link == ROOT else s for s in asset.sites),
        regions=tuple(r.replace(pose=shift @ r.pose) if r.link == ROOT else r for r in asset.regions),
    )


def _point(pose: Pose, point: Vec3) -> Vec3:
    x, y, z = pose.apply(np.array([point]))[0]
    return float(x), float(y), float(z)


def _shifted(mesh: Mesh, by: Vec3) -> Mesh:
    vertices = (mesh.vertices + np.array(by)).astype(np.float32).astype(np.float64)
    return mesh.with_vertices(vertices, mesh.normals)


def _merged(meshes: Sequence[Mesh]) -> Mesh:
    """Concatenate meshes."""
    if len(meshes) == 1:
        return meshes[0]
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    uv = [m.uv for m in meshes if m.uv is not None]
    normals = [m.normals for m in meshes if m.normals is not None]
    return Mesh(
        vertices=np.concatenate([m.vertices for m in meshes]),
        faces=np.concatenate([m.faces + s for m, s in zip(meshes, starts, strict=False)]),
        uv=np.concatenate(uv) if uv else None,
        normals=np.concatenate(normals),
    )


def _inertial(piece: LinkBuilder) -> Inertial:
    """Mass properties of all that is on a link."""
    if not piece.masses:
        raise ValueError(f"link {piece.name!r} weighs nothing")
    whole = combine_masses(piece.masses)
    tensor = whole.inertia
    # A thin plate's moments touch A + B = C; rounding must not carry them beyond.
    tensor = tensor + np.eye(3) * 1e-6 * float(np.trace(tensor))
    xx, yy, zz, xy, xz, yz = (_digits(tensor[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    x, y, z = (_digits(v) for v in whole.center)
    return Inertial(mass=_digits(whole.mass), center_of_mass=(x, y, z), inertia=(xx, yy, zz, xy, xz, yz))


def _digits(value: float) -> float:
    """Round to seven significant digits, which MJCF and USD both keep."""
    return significant(value, 7) if math.isfinite(value) else value
