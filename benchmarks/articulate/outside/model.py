"""An articulated object as a file states it: links with their visible triangles at the closed pose, and joints."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from casa_assets import registry
from casa_assets.core.numeric import Floats
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Refused
from casa_assets.ingest.things import load
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.parts import Shape
from casa_assets.model.pose import Pose

# The box around an object with a joint shut is smaller than this share of that with it open.
MIN_SHRINKAGE = 0.97
# Values of a joint at which it is tried whether it is shut.
TRIED_VALUES = 25
# Names of joints and links that are no parts of what a person opens, such as casters.
UNSCORED = ("wheel", "caster", "castor")


class Unreadable(Exception):
    """An object cannot be read, for the reason that is given."""


@dataclass(frozen=True)
class Joint:
    """How a link moves against its parent, in the axes and units of the object, from the closed pose.

    Attributes:
        kind: `revolute`, `continuous` or `prismatic`. axis: unit. origin: a point of it.
        range: lowest and highest value, 0 at the closed pose; rad or units.
    """

    name: str
    kind: str
    axis: Floats
    origin: Floats
    range: tuple[float, float]

    @property
    def is_fixed(self) -> bool:
        """True if it cannot move."""
        return self.kind != "continuous" and self.range[1] - self.range[0] < 1e-6


@dataclass
class Link:
    """A rigid piece.

    Attributes:
        parent: name, empty for the root. joint: None if it is fixed to its parent.
        meshes: triangles of each visible shape at the closed pose, (F, 3, 3).
    """

    name: str
    parent: str = ""
    joint: Joint | None = None
    meshes: list[Floats] = field(default_factory=list)


@dataclass
class Model:
    """Links by name, the root first. up: axis of the file that points up."""

    links: dict[str, Link]
    up: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))


def subtree(model: Model, root: str) -> Model:
    """Return what hangs on a link of a scene, with that link as its root. Raises Unreadable if there is none."""
    if root not in model.links:
        raise Unreadable(f"it has no link '{root}'; there are {', '.join(sorted(model.links)[:40])}")
    kept = {root: Link(root, "", None, model.links[root].meshes)}
    grown = True
    while grown:
        new = {n: link for n, link in model.links.items() if n not in kept and link.parent in kept}
        kept |= new
        grown = bool(new)
    return Model(kept, model.up)


def moved(triangles: Floats, pose: Floats) -> Floats:
    """Return (F, 3, 3) triangles under a (4, 4) transform; mirrored ones are turned round."""
    out: Floats = triangles @ pose[:3, :3].T + pose[:3, 3]
    return out[:, ::-1] if np.linalg.det(pose[:3, :3]) < 0 else out


def transform(position: Sequence[float], rotation: Floats | None = None) -> Floats:
    """Return the (4, 4) transform of a position and a (3, 3) rotation."""
    out: Floats = np.eye(4)
    out[:3, 3] = position
    if rotation is not None:
        out[:3, :3] = rotation
    return out


def roll_pitch_yaw(angles: Sequence[float]) -> Floats:
    """Return the (3, 3) rotation of URDF's and SDF's angles, rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def about(axis: Floats, angle: float) -> Floats:
    """Return the (3, 3) rotation about a unit axis."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: Floats = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return turned


def primitive(shape: Shape) -> Floats:
    """Return the triangles of a primitive about the origin."""
    points, faces = tessellate(shape, Pose())
    return points[faces]


def mesh_file(path: Path, known: dict[tuple[Path, str], Floats], part: str = "", turns: bool = False) -> Floats:
    """Return the triangles of a mesh file in its own axes, in metres where it states a unit.

    Args:
        known: files that were read before. part: name of a node, empty for the whole file.
        turns: turn a file that states y up to z up, as the readers of URDF do for COLLADA.
    Raises:
        Unreadable: it is missing or broken.
    """
    if (path, part) not in known:
        if not path.is_file():
            raise Unreadable(f"'{path.name}' is missing")
        found = next(discover([path]))
        if isinstance(found, Refused):
            raise Unreadable(f"'{path.name}': {found}")
        model = load(collect(found, registry.load().limits), registry.load().limits)
        parts = [p for p in model.parts if not part or part in (p.name, *p.nodes)]
        corners = np.concatenate([p.mesh.vertices[p.mesh.faces] for p in parts or model.parts])
        is_collada = path.suffix.lower() == ".dae"
        corners = corners * ((model.metres_per_unit or 1.0) if is_collada else 1.0)
        if turns and is_collada and model.up is not None and model.up.value == "y":
            corners = corners @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
        known[path, part] = corners
    return known[path, part]


def closed_value(low: float, high: float, stated: float | None) -> float:
    """Return the value of a joint at the closed pose: as stated, else 0 or the limit that is nearest to it."""
    return min(max(0.0, low), high) if stated is None else stated


def with_closed_pose(
    links: Mapping[str, tuple[str, Floats, list[Floats]]],
    joints: Mapping[str, tuple[str, str, Floats, tuple[float, float]]],
    values: Mapping[str, float],
) -> dict[str, Link]:
    """Place links that are given by transforms against their parents.

    Args:
        links: name -> parent, (4, 4) pose in the parent at 0, and shapes in its own axes; parents come first.
        joints: name of the link -> name of the joint, kind, (3,) axis in the link's axes, and range.
        values: of joints at the closed pose, by name, where it is not 0.
    """
    world: dict[str, Floats] = {"": np.eye(4)}
    out = {}
    for name, (parent, pose, meshes) in links.items():
        at = world[parent] @ pose
        joint = None
        if name in joints:
            word, kind, axis, (low, high) = joints[name]
            unit = axis / max(float(np.linalg.norm(axis)), 1e-12)
            closed = closed_value(low, high, values.get(word))
            move = transform(unit * closed) if kind == "prismatic" else transform((0, 0, 0), about(unit, closed))
            at = at @ move
            reach = (low - closed, high - closed)
            joint = Joint(word, kind, at[:3, :3] @ unit, at[:3, 3].copy(), reach)
            joint = None if joint.is_fixed else joint
        world[name] = at
        out[name] = Link(name, parent, joint, [moved(m, at) for m in meshes])
    return out


def at_closed_pose(model: Model, stated: Collection[str] = ()) -> Model:
    """Return a model with doors, lids and drawers shut that its file leaves open at 0.

    A joint is shut where the box around everything is clearly smallest.

    Args:
        stated: names of joints whose closed pose is known.
    """
    for name in list(model.links):
        joint = model.links[name].joint
        if joint is None or joint.kind == "continuous" or joint.name in stated:
            continue
        tried = [0.0, *joint.range, *np.linspace(*joint.range, TRIED_VALUES).tolist()]
        sizes = {v: _volume(_with_value(model, name, v)) for v in tried}
        best = min(tried, key=lambda v: sizes[v])
        if sizes[best] < MIN_SHRINKAGE * sizes[0.0]:
            model = _with_value(model, name, best)
    return model


def _volume(model: Model) -> float:
    corners = np.concatenate(
        [c.reshape(-1, 3) for link in model.links.values() for c in link.meshes] or [np.zeros((1, 3))]
    )
    return float((np.ptp(corners, axis=0) + 1e-6).prod())


def _with_value(model: Model, name: str, value: float) -> Model:
    """Return a model with one joint at a value, from which its range then counts."""
    joint = model.links[name].joint
    assert joint is not None
    if joint.kind == "prismatic":
        move = transform(joint.axis * value)
    else:
        turn = about(joint.axis, value)
        move = transform(joint.origin - turn @ joint.origin, turn)
    links = dict(model.links)
    carried = {name}
    for other in model.links.values():
        if other.name != name and other.parent not in carried:
            continue
        carried.add(other.name)
        own = other.joint
        if own is not None:
            origin = move[:3, :3] @ own.origin + move[:3, 3]
            reach = (own.range[0] - value, own.range[1] - value) if other.name == name else own.range
            own = Joint(own.name, own.kind, move[:3, :3] @ own.axis, origin, reach)
        links[other.name] = Link(other.name, other.parent, own, [moved(m, move) for m in other.meshes])
    return Model(links, model.up)


def parents_first(parents: Mapping[str, str]) -> list[str]:
    """Return the names so that every parent stands before its children. Raises Unreadable where they form a ring."""
    out: list[str] = []
    left = list(parents)
    while left:
        ready = [n for n in left if parents[n] in out or parents[n] not in parents]
        if not ready:
            raise Unreadable(f"its links form a ring: {', '.join(left[:8])}")
        out += ready
        left = [n for n in left if n not in ready]
    return out
