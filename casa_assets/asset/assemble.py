"""A family, and how its AssetBuilder becomes an Asset: meshes, masses, friction of joints, rounded numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic

import numpy as np

from casa_assets.asset.asset_builder import ROOT, AssetBuilder, JointBuilder, LinkBuilder, VisualPart, combine_masses
from casa_assets.asset.family import AvailableFinishes, P, Params, Supplies, pick
from casa_assets.asset.solid import solid_mesh
from casa_assets.core import hand_dynamics
from casa_assets.core.numeric import Floats, significant
from casa_assets.model.asset.asset import Asset, Base, Drive, Inertial, Joint, JointKind, Provenance, Region, Visual
from casa_assets.model.asset.asset import Link as AssetLink
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Link, Mesh, MeshShape, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Round the numbers of an asset so that runs on different machines nearly always write the same bytes.
#
# The vector unit of a processor, and even the alignment of an array in memory, changes the last bit of a product.
# Rounding hides that bit and changes nothing that can be seen or measured. A value on a rounding boundary can still
# differ. Rounded are poses, anchors and axes of joints, sizes of regions and shapes, vertices of colliders and of
# visual meshes, normals, texture coordinates and centres of mass. Masses are not rounded; of the inertia, only entries
# that are zero but for rounding errors are set to 0.

LENGTH_DECIMALS = 9  # of metres, except in visual meshes; also of unit axes
# Of metres in visual meshes. These are stored as float32, which near 0.1 m is exact to about 1e-8 m.
MESH_DECIMALS = 8
QUATERNION_DECIMALS = 12
VISUAL_DECIMALS = 7  # of normals and texture coordinates
INERTIA_TOLERANCE = 1e-10  # entries below this share of the trace are set to 0


def quantize(asset: Asset) -> Asset:
    """Return the asset with its lengths, rotations, normals and texture coordinates rounded."""
    return asset.replace(
        links=tuple(_rounded_link(k) for k in asset.links),
        joints=tuple(j.replace(anchor=_rounded_vec(j.anchor), axis=_rounded_vec(j.axis)) for j in asset.joints),
        sites=tuple(s.replace(pose=_rounded_pose(s.pose)) for s in asset.sites),
        regions=tuple(r.replace(pose=_rounded_pose(r.pose), size=_rounded_vec(r.size)) for r in asset.regions),
    )


def _rounded_link(link: Link) -> Link:
    """The link with its lengths and rotations rounded and rounding errors in its inertia set to 0."""
    inertial = link.inertial
    if inertial is not None:
        threshold = INERTIA_TOLERANCE * sum(inertial.inertia[:3])
        inertia = tuple(0.0 if abs(v) < threshold else v for v in inertial.inertia)
        inertial = inertial.replace(center_of_mass=_rounded_vec(inertial.center_of_mass), inertia=inertia)
    return link.replace(
        pose=_rounded_pose(link.pose),
        inertial=inertial,
        visuals=tuple(v.replace(mesh=_rounded_mesh(v.mesh)) for v in link.visuals),
        colliders=tuple(c.replace(pose=_rounded_pose(c.pose), shape=_rounded_shape(c.shape)) for c in link.colliders),
    )


def _rounded_shape(shape: Shape) -> Shape:
    """The collision shape with its lengths rounded."""
    if isinstance(shape, Box):
        return shape.replace(size=_rounded_vec(shape.size))
    if isinstance(shape, Sphere):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS))
    if isinstance(shape, Cylinder | Capsule):
        return shape.replace(radius=round(shape.radius, LENGTH_DECIMALS), height=round(shape.height, LENGTH_DECIMALS))
    assert isinstance(shape, Hull | MeshShape)
    vertices = np.round(shape.mesh.vertices, LENGTH_DECIMALS) + 0.0
    return shape.replace(mesh=shape.mesh.with_vertices(vertices, shape.mesh.normals))


def _rounded_mesh(mesh: Mesh) -> Mesh:
    """The visual mesh with vertices, texture coordinates and normals rounded to float32."""
    vertices = _rounded_float32(mesh.vertices, MESH_DECIMALS)
    uv, normals = (None if v is None else _rounded_float32(v, VISUAL_DECIMALS) for v in (mesh.uv, mesh.normals))
    return Mesh(vertices=vertices, faces=mesh.faces, uv=uv, normals=normals)


def _rounded_float32(values: Floats, places: int) -> Floats:
    """Round to decimals, then to the nearest float32; adding 0 turns -0.0 into 0.0."""
    return (np.round(values, places) + 0.0).astype(np.float32).astype(np.float64)


def _rounded_vec(values: Vec3) -> Vec3:
    """Three numbers rounded to LENGTH_DECIMALS; adding 0 turns -0.0 into 0.0."""
    x, y, z = (round(v, LENGTH_DECIMALS) + 0.0 for v in values)
    return (x, y, z)


def _rounded_pose(pose: Pose) -> Pose:
    """The pose with its position and its quaternion rounded."""
    w, x, y, z = (round(q, QUATERNION_DECIMALS) + 0.0 for q in pose.quaternion)
    return Pose(position=_rounded_vec(pose.position), quaternion=(w, x, y, z))


MASS_DIGITS = 7  # significant digits of masses, centres and moments; MJCF and USD both keep them


def assemble(builder: AssetBuilder, family: str, params: Params) -> Asset:
    """Return the finished Asset; its id is the family and the first 10 hex digits of the digest of its parameters."""
    inertials = {name: _inertial(link) for name, link in builder.links.items()}
    links = tuple(
        AssetLink(
            name=link.name,
            parent=link.parent,
            pose=link.pose,
            inertial=inertials[link.name],
            visuals=_visuals(builder, link),
            colliders=tuple(link.colliders),
        )
        for link in _ordered(builder)
    )
    finishes = builder.supplies.finishes
    substances = {f.substance.id: f.substance for f in finishes.values()}
    asset = Asset(
        id=f"{family}_{params.digest[:10]}",
        base=builder.base,
        links=links,
        joints=tuple(_joint(builder, joint, inertials) for joint in builder.joints),
        sites=tuple(builder.sites),
        regions=tuple(builder.regions),
        states=tuple(builder.states),
        keyframes=tuple(builder.keyframes),
        behavior=builder.behavior.build(),
        contract=builder.contract,
        materials=tuple(finishes[name].material for name in sorted({v.material for k in links for v in k.visuals})),
        substances=tuple(substances[name] for name in sorted({c.substance for k in links for c in k.colliders})),
        labels=builder.supplies.labels.replace(portion=builder.portion),
        provenance=Provenance(
            source="family",
            path=family,
            sha256=params.digest,
            title=family.replace("_", " "),
            licence="Apache-2.0",
            generator="casa-assets families",
        ),
    )
    return add_main_region(quantize(share_asset_frame(center_footprint(asset))))


def _ordered(builder: AssetBuilder) -> list[LinkBuilder]:
    """Links with parents before children, else in the order they were added."""
    ordered: list[LinkBuilder] = []
    remaining = list(builder.links.values())
    while remaining:
        ready = [p for p in remaining if p.parent is None or any(o.name == p.parent for o in ordered)]
        if not ready:
            raise ValueError(f"link {remaining[0].name!r}: there is no link {remaining[0].parent!r}")
        ordered += ready
        remaining = [p for p in remaining if p not in ready]
    return ordered


def _visuals(builder: AssetBuilder, link: LinkBuilder) -> tuple[Visual, ...]:
    groups: dict[tuple[str, str | None, str | None], list[VisualPart]] = {}
    for part in link.parts:
        groups.setdefault((part.finish, part.label, part.name), []).append(part)
    out = []
    for (finish, label, name), parts in groups.items():
        tile = builder.supplies.finish(finish).tile_m
        prefix = name or f"{link.name}_{label or 'body'}_{finish}"
        meshes = [solid_mesh(part.solid, tile, part.grain, f"{prefix}/{i}") for i, part in enumerate(parts)]
        out.append(Visual(name=f"{prefix}_visual", mesh=_merged(meshes), material=finish, label=label))
    return tuple(out)


def _joint(builder: AssetBuilder, joint: JointBuilder, inertials: dict[str, Inertial]) -> Joint:
    lever = _lever(builder, joint) if joint.lever is None else joint.lever
    travel = joint.range[1] - joint.range[0]
    inertia = _resistance(builder, joint, inertials)
    feel = joint.feel or hand_dynamics.feel_against(joint.spring, inertia, lever, travel, joint.start_n, joint.push_n)
    spring = joint.spring
    return Joint(
        name=joint.name,
        child=joint.child,
        kind=joint.kind,
        axis=joint.axis,
        anchor=joint.anchor,
        range=joint.range,
        damping=feel.damping,
        frictionloss=feel.frictionloss,
        armature=feel.armature,
        drive=Drive(stiffness=spring.stiffness, damping=0.0, target=spring.rest) if spring else None,
        grip=joint.grip,
        behind=joint.behind,
    )


def _lever(builder: AssetBuilder, joint: JointBuilder) -> float:
    """Distance from the hinge's axis to the middle of the grip, metres."""
    grips = [c for c in builder.links[joint.child].colliders if c.name == joint.grip]
    if not grips:
        raise ValueError(f"joint {joint.name!r}: link {joint.child!r} has no collider {joint.grip!r}")
    arm = np.array(grips[0].pose.position) - np.array(joint.anchor)
    axis = np.array(joint.axis)
    return max(0.01, float(np.linalg.norm(arm - axis * float(arm @ axis) / float(axis @ axis))))


def _resistance(builder: AssetBuilder, joint: JointBuilder, inertials: dict[str, Inertial]) -> float:
    """Inertia of everything a joint moves: kg*m^2 about a hinge's axis, or kg along a slide."""
    carried = _carried(builder, joint.child, Pose())
    if joint.kind is JointKind.SLIDE:
        return sum(inertials[name].mass for name, _ in carried)
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    total = 0.0
    for name, pose in carried:
        body = inertials[name]
        arm = pose.apply(np.array([body.center_of_mass]))[0] - np.array(joint.anchor)
        turned = pose.rotation @ body.tensor @ pose.rotation.T
        offset = arm - axis * float(arm @ axis)
        total += float(axis @ turned @ axis) + body.mass * float(offset @ offset)
    return total


def _carried(builder: AssetBuilder, name: str, pose: Pose) -> list[tuple[str, Pose]]:
    """A link and its descendants, each with its pose in the frame of the first."""
    out = [(name, pose)]
    for child in builder.links.values():
        if child.parent == name:
            out += _carried(builder, child.name, pose @ child.pose)
    return out


def add_main_region(asset: Asset) -> Asset:
    """Add a region `main`, the bounding box of the asset, unless there is one or the asset has no runtime contract."""
    if asset.contract is None or any(region.name == "main" for region in asset.regions):
        return asset
    lower, upper = asset.bounds
    center, size = (tuple(float(v) for v in values) for values in ((lower + upper) / 2, upper - lower))
    return asset.replace(regions=(*asset.regions, Region(name="main", pose=Pose(position=center), size=size)))


def center_footprint(asset: Asset) -> Asset:
    """The asset moved so that the middle of its footprint is the origin, on the ground, joints at zero."""
    lower, upper = asset.bounds
    x, y, z = (float(np.float32(v)) for v in (-(lower[0] + upper[0]) / 2, -(lower[1] + upper[1]) / 2, -lower[2]))
    shift = Pose(position=(x, y, z))
    root_link = _shifted_link(asset.root, (x, y, z))
    others = tuple(k.replace(pose=shift @ k.pose) if k.parent == ROOT else k for k in asset.links[1:])
    return asset.replace(
        links=(root_link, *others),
        sites=tuple(s.replace(pose=shift @ s.pose) if s.link == ROOT else s for s in asset.sites),
        regions=tuple(r.replace(pose=shift @ r.pose) if r.link == ROOT else r for r in asset.regions),
    )


def share_asset_frame(asset: Asset) -> Asset:
    """The asset with the frame of every link that carries a region, and of what carries that link, at its origin.

    A region's place on its link is then its place on the asset. Ref: RoboCasa v1.0, Fixture: it reads the `pos` of a
    region as if it were in the fixture's own frame; its own drawers have moving bodies at 0 0 0, too.
    Links that are turned against the asset keep their frames, and all that they carry.
    """
    kept = asset
    for link in asset.links:
        if any(region.link == link.name for region in asset.regions):
            for name in reversed(_carriers(asset, link.name)):
                kept = _at_parent(kept, name)
    return kept


def _carriers(asset: Asset, name: str) -> list[str]:
    """A link and the links that carry it, without the root."""
    parent = asset.link(name).parent
    return [] if parent is None else [name, *_carriers(asset, parent)]


def _at_parent(asset: Asset, name: str) -> Asset:
    """The asset with the frame of a link moved into that of its parent; nothing moves in the world."""
    link = asset.link(name)
    if link.pose.quaternion != Pose().quaternion:
        return asset
    by = Pose(position=link.pose.position)
    moved = _shifted_link(link, by.position).replace(pose=Pose())
    others = (k.replace(pose=by @ k.pose) if k.parent == name else k for k in asset.links)
    return asset.replace(
        links=tuple(moved if k.name == name else k for k in others),
        joints=tuple(j.replace(anchor=_point(by, j.anchor)) if j.child == name else j for j in asset.joints),
        sites=tuple(s.replace(pose=by @ s.pose) if s.link == name else s for s in asset.sites),
        regions=tuple(r.replace(pose=by @ r.pose) if r.link == name else r for r in asset.regions),
    )


def _shifted_link(link: AssetLink, by: Vec3) -> AssetLink:
    """The link with all that is on it moved in its own frame, metres."""
    shift = Pose(position=by)
    return link.replace(
        inertial=link.inertial.replace(center_of_mass=_point(shift, link.inertial.center_of_mass)),
        visuals=tuple(v.replace(mesh=_shifted(v.mesh, by)) for v in link.visuals),
        colliders=tuple(c.replace(pose=shift @ c.pose) for c in link.colliders),
    )


def _point(pose: Pose, point: Vec3) -> Vec3:
    x, y, z = pose.apply(np.array([point]))[0]
    return float(x), float(y), float(z)


def _shifted(mesh: Mesh, by: Vec3) -> Mesh:
    return mesh.with_vertices((mesh.vertices + np.array(by)).astype(np.float32).astype(np.float64), mesh.normals)


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


def _inertial(link: LinkBuilder) -> Inertial:
    """Mass properties of all that is on a link."""
    if not link.masses:
        raise ValueError(f"link {link.name!r} weighs nothing")
    total = combine_masses(link.masses)
    tensor = total.inertia
    # Principal moments of a thin plate satisfy A + B = C; this margin keeps A + B >= C after rounding.
    tensor = tensor + np.eye(3) * 1e-6 * float(np.trace(tensor))
    entries = [tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    xx, yy, zz, xy, xz, yz = (significant(v, MASS_DIGITS) for v in entries)
    x, y, z = (significant(v, MASS_DIGITS) for v in total.center)
    mass = significant(total.mass, MASS_DIGITS)
    return Inertial(mass=mass, center_of_mass=(x, y, z), inertia=(xx, yy, zz, xy, xz, yz))


@dataclass(frozen=True)
class Family(Generic[P]):
    """A family of fixtures, or a form of objects: a type of parameters and the code that builds a member.

    In this package `title`, `category`, `description`, `presets` and most often `sample` are data, in
    registry/families/ and registry/objects/. A plug-in states here what is not to be the default.

    Attributes:
        name: such as `microwave`; of objects their category.
        params: the type of its parameters.
        add_parts: adds links, joints, sites and regions of a member to an empty builder; no randomness.
        sample: draws a member, each number within the bounds of its type; without it, one of the presets is drawn.
        contract: id in registry/contracts/, if `add_parts` does not choose it.
        base: FREE if a member is a movable object.
        title: one line; by default the name in words.
        category: id in registry/fixtures.yaml, or of objects in registry/categories.yaml; by default the name.
        description: one sentence about its members; by default the docstring of `params`.
        presets: named members, each visibly different; by default `default`, with all defaults of `params`.
        form: of objects, the name of their form; empty for fixtures.
    """

    name: str
    params: type[P]
    add_parts: Callable[[AssetBuilder, P], None]
    sample: Callable[[np.random.Generator, AvailableFinishes], P] | None = None
    contract: str | None = None
    base: Base = Base.FIXED
    title: str = ""
    category: str = ""
    description: str = ""
    presets: Mapping[str, P] = field(default_factory=dict)
    form: str = ""

    def draw(self, rng: np.random.Generator, available: AvailableFinishes) -> P:
        """A random member."""
        return self.sample(rng, available) if self.sample else self.presets[pick(rng, list(self.presets))]

    def build(self, params: P, supplies: Supplies) -> Asset:
        """The asset of a member's parameters."""
        builder = AssetBuilder(supplies, self.base)
        builder.contract = self.contract
        self.add_parts(builder, params)
        return assemble(builder, self.name, params)
