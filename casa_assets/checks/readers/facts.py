"""Tables of facts that the files of an asset are reduced to, the table of the asset itself, and their comparison.

A table is a dictionary of cells: texts, numbers, tuples of them, or rows, which are dictionaries under their names.
Equal tables mean parity. Cells are compared in the order in which the table that is expected has them.

of an asset    base: `free` or `fixed`; exclusions: pairs of bodies; the words below; bodies, places, looks, poses
of a scene     gravity: m/s^2; placements, cameras, lights; exclusions, bodies, places, looks and poses of all
               placements under their names in the scene, `cup` and `cup__handle`

words          for programs that read names. classes: semantic labels from the category upwards; portion: the part that
               remains of a thing that was cut, or empty; labels: (visual or collider, label of the part); grips:
               (joint, collider that a hand takes); behind: (joint, joint that has to be open); contract: id, or
               empty; behavior: sha256 of the state machine's canonical JSON, or empty; states
states         joint, value; interval: fractions of the way of the joint from closed to open
bodies         called as in the asset: `object` is the root. parent: name, empty for the root; colliders: how many;
               position, quaternion: root_from_body with every joint at zero; center_of_mass; lower, upper: corners of
               all colliders, zero without any; mass: kg; inertia: (xx, yy, zz, xy, xz, yz) about the centre of mass,
               kg*m^2; frictions: distinct (sliding, torsional, rolling) of the colliders; joint: to its parent, or None
joint          name, kind; axis, anchor: body frame; range: rad or m; resistance: stiffness (N*m/rad or N/m), where
               that spring rests (rad or m), damping, frictionloss, armature
places         sites and regions. body; kind: sphere, box or cylinder; position, quaternion: body_from_place; size: full
               size, the diameter three times of a sphere, (diameter, diameter, height) of a cylinder; color: linear
               RGBA of a site, None of a region
looks          of visuals, as far as both formats hold it alike. color: linear RGBA, by which its picture is multiplied;
               light: linear RGB that it gives off by itself, times its picture; picture: file name, or empty
poses          of each named pose the position and quaternion of each body: root_from_body, of a scene world_from_body;
               `closed` is among them if there are any
placements     asset: id; layer: thing, room or ceiling; base; position, quaternion: world_from_root as physics finds
               it, every joint at zero; its words, with the names that things have in the asset
cameras        position, quaternion: world_from_camera, looking along -z with y up; fov_y_deg: vertical field of view
lights         without their brightness, of which the formats have different notions. kind: directional, point or spot;
               castshadow, position; direction: unit vector along which it shines, zero where it shines to all sides;
               tint: its colour, the largest share 1; cone_deg: of a spot, else 0

Lengths in metres, by default in the frame of the body.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from casa_assets.checks.check import Measurement, Problem
from casa_assets.core.numeric import Floats, about_axis
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, Collider, Drive, Joint, JointKind, Link, Region, Site, Visual
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

Cells = dict[str, Any]
Pairs = Iterable[tuple[str, str]]
NamedRows = Iterable[tuple[str, Cells]]

# The outer volume that MJCF holds also of an asset that names none: the bounds of colliders that are compared anyway.
OUTER = "bbox"
# The pose that every asset with named poses has, written or not: all joints at zero.
CLOSED = "closed"
# The prim that holds the placements of a scene (no asset is called so), and the root link of an asset.
WORLD, ROOT_BODY = "World", "object"
# Cells in metres; a range is one where the joint slides.
LENGTHS = frozenset({"position", "center_of_mass", "lower", "upper", "anchor", "size"})
ANGLE_TOLERANCE_DEG = 1e-4

# Rows -----------------------------------------------------------------------------------------------------------------


def rows(found: NamedRows) -> Cells:
    """Rows by name, sorted. Raises ValueError where two have one name."""
    named = sorted(found, key=lambda row: row[0])
    if twice := [one for (one, _), (other, _) in pairwise(named) if one == other]:
        raise ValueError(f"there are two {twice[0]!r}")
    return dict(named)


def asset_table(
    base: str, words: Cells, exclusions: Pairs, bodies: NamedRows, places: NamedRows, looks: NamedRows, poses: NamedRows
) -> Cells:
    """The table of an asset, or of all that a scene holds."""
    return {
        "base": base,
        "exclusions": tuple(sorted({(min(pair), max(pair)) for pair in exclusions})),
        **words,
        "bodies": rows(bodies),
        "places": rows((name, row) for name, row in places if own_name(name) != OUTER),
        "looks": rows(looks),
        "poses": rows(poses),
    }


def scene_table(gravity: Vec3, placements: NamedRows, cameras: NamedRows, lights: NamedRows, things: Cells) -> Cells:
    """The table of a scene; `things`: of the bodies of all placements."""
    found = {"gravity": gravity, "placements": rows(placements), "cameras": rows(cameras), "lights": rows(lights)}
    return found | {name: things[name] for name in ("exclusions", "bodies", "places", "looks", "poses")}


def words_cells(classes: Iterable[str], states: NamedRows, **cells: str | Pairs) -> Cells:
    """Words that programs read; `cells`: portion, contract and behavior, and the pairs of names."""
    found = {name: cell if isinstance(cell, str) else tuple(sorted(cell)) for name, cell in cells.items()}
    return {"classes": tuple(classes), **found, "states": rows(states)}


def state_cells(joint: str, value: str, low: float | str, high: float | str) -> Cells:
    """A named interval of a joint."""
    return {"joint": joint, "value": value, "interval": (float(low), float(high))}


def frame(pose: Pose) -> Cells:
    """The two cells of a pose."""
    return {"position": pose.position, "quaternion": pose.quaternion}


def body_cells(
    *,
    parent: str,
    place: Pose,
    mass: float,
    center_of_mass: Vec3,
    inertia: Sequence[float],
    colliders: int,
    boxes: Sequence[Floats],
    frictions: Iterable[Vec3],
    joint: Cells | None,
) -> Cells:
    """A body; `place`: root_from_body, `boxes`: (2, 3) corners of boxes around its colliders."""
    nothing = [np.zeros((2, 3))]
    return {
        "parent": parent,
        "colliders": colliders,
        "position": place.position,
        "center_of_mass": center_of_mass,
        "lower": three(np.min([box[0] for box in boxes or nothing], axis=0)),
        "upper": three(np.max([box[1] for box in boxes or nothing], axis=0)),
        "quaternion": place.quaternion,
        "mass": mass,
        "inertia": tuple(inertia),
        "frictions": tuple(sorted(set(frictions))),
        "joint": joint,
    }


def joint_cells(
    name: str, kind: JointKind, axis: Vec3, anchor: Vec3, travel: Sequence[float], resistance: Sequence[float]
) -> Cells:
    """A joint; `travel`: from the least to the largest position."""
    low, high = (float(n) for n in travel)
    at = {"name": name, "kind": kind, "axis": axis, "anchor": anchor}
    return {**at, "range": (low, high), "resistance": tuple(resistance)}


def place_cells(body: str, kind: str, place: Cells, size: Sequence[float], color: Sequence[float] | None) -> Cells:
    """A site, or a region, which has no colour; `place`: body_from_place."""
    return {"body": body, "kind": kind, **place, "size": tuple(size), "color": color and tuple(color)}


def round_size(kind: str, size: Sequence[float]) -> Sequence[float]:
    """Full size of a place whose record may be wider along y: a cylinder is as wide as its size along x."""
    return (size[0], size[0], size[2]) if kind == "cylinder" else size


def look_cells(color: Sequence[float], light: Iterable[float], picture: str) -> Cells:
    """How a visual looks."""
    return {"color": tuple(color), "light": tuple(light), "picture": picture}


def seen_from(root: str, frames: Cells) -> Cells:
    """Frames of bodies in that of one of them."""
    poses = {body: Pose(**cells) for body, cells in frames.items()}
    root_from_world = poses[root].inverse()
    return {body: frame(root_from_world @ pose) for body, pose in sorted(poses.items())}


def short_name(name: str) -> str:
    """`/mug_0123456789/object` -> `object`: names that come from USD are prim paths.

    In a scene they are called as in MJCF: `/World/cup/object` -> `cup`, `/World/cup/object/sites/fill` -> `cup__fill`.
    """
    parts = name.split("/")
    if len(parts) < 4 or parts[1] != WORLD:
        return parts[-1]
    return parts[2] if parts[3:] == [ROOT_BODY] else f"{parts[2]}__{parts[-1]}"


def own_name(name: str) -> str:
    """`cup__fill` -> `fill`: a name within its placement."""
    return name.rsplit("__", 1)[-1]


def three(values: Iterable[float] | Floats) -> Vec3:
    """Three numbers as floats of Python."""
    x, y, z = (float(v) for v in values)
    return x, y, z


def four(values: Iterable[float] | Floats) -> Vec4:
    """Four numbers as floats of Python."""
    w, x, y, z = (float(v) for v in values)
    return w, x, y, z


def tensor_entries(tensor: Floats) -> tuple[float, ...]:
    """(xx, yy, zz, xy, xz, yz) of a symmetric (3, 3) tensor."""
    return tuple(float(tensor[at]) for at in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


# Asset ----------------------------------------------------------------------------------------------------------------


def asset_facts(asset: Asset) -> Cells:
    """The table of an asset: joints at zero, root at the origin."""
    named = {CLOSED: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}
    items: list[Site | Region] = [*asset.sites, *asset.regions]
    return asset_table(
        base=asset.base,
        words=_words(asset),
        exclusions=[(pair.first, pair.second) for pair in asset.exclusions],
        bodies=[(link.name, _body(asset, link)) for link in asset.links],
        places=[(item.name, _place(item)) for item in items],
        looks=_looks(asset),
        poses=[(name, _frames(asset, named[name])) for name in named] if asset.keyframes else (),
    )


def _body(asset: Asset, link: Link) -> Cells:
    bounds, inertial = link_bounds(link), link.inertial
    matters = [asset.substance(collider.substance) for collider in link.colliders]
    return body_cells(
        parent=link.parent or "",
        place=asset.root.pose.inverse() @ asset.asset_from_link(link.name),
        mass=inertial.mass,
        center_of_mass=inertial.center_of_mass,
        inertia=inertial.inertia,
        colliders=len(link.colliders),
        boxes=[] if bounds is None else [bounds],
        # MuJoCo has one coefficient for sliding, that of motion.
        frictions=[(m.dynamic_friction, m.torsional_friction, m.rolling_friction) for m in matters],
        joint=_joint(asset.joint_of(link.name)),
    )


def _joint(joint: Joint | None) -> Cells | None:
    if joint is None:
        return None
    drive = joint.drive or Drive(stiffness=0.0, damping=0.0)
    resistance = (drive.stiffness, drive.target, joint.damping + drive.damping, joint.frictionloss, joint.armature)
    return joint_cells(joint.name, joint.kind, joint.axis, joint.anchor, joint.range, resistance)


def _place(item: Site | Region) -> Cells:
    x, y, z = item.size if item.size is not None else (2 * item.radius,) * 3
    color = item.color if isinstance(item, Site) else None
    return place_cells(item.link, item.kind, frame(item.pose), round_size(item.kind, (x, y, z)), color)


def _looks(asset: Asset) -> Iterator[tuple[str, Cells]]:
    by_id = {material.id: material for material in asset.materials}
    for visual in (v for link in asset.links for v in link.visuals):
        material = by_id[visual.material]
        light = [material.glow * channel for channel in material.base_color[:3]]
        file = material.base_color_texture.file_name if material.base_color_texture is not None else ""
        yield visual.name, look_cells(material.base_color, light, file)


def _frames(asset: Asset, values: dict[str, float]) -> Cells:
    """Forward kinematics, parents before children, by other formulas than those that the writers use."""
    root_from: dict[str, Pose] = {}
    for link in asset.links:
        if link.parent is None:
            root_from[link.name] = Pose()
            continue
        joint = asset.joint_of(link.name)
        moved = Pose() if joint is None else _joint_pose(joint, values.get(joint.name, 0.0))
        root_from[link.name] = root_from[link.parent] @ link.pose @ moved
    return {name: frame(pose) for name, pose in sorted(root_from.items())}


def _joint_pose(joint: Joint, value: float) -> Pose:
    """Pose of the child in its own frame at zero. Ref: p - R p for a turn about the point p."""
    axis, anchor = np.array(joint.axis), np.array(joint.anchor)
    if joint.kind is JointKind.SLIDE:
        return Pose(position=three(axis * value))
    matrix = np.eye(4)
    matrix[:3, :3] = about_axis(axis, value)
    matrix[:3, 3] = anchor - matrix[:3, :3] @ anchor
    return Pose.from_matrix(matrix)


def _words(asset: Asset) -> Cells:
    shapes: list[Collider | Visual] = []
    for link in asset.links:
        shapes += (*link.visuals, *link.colliders)
    return words_cells(
        classes=asset.labels.classes,
        portion=asset.labels.portion or "",
        labels=[(shape.name, shape.label) for shape in shapes if shape.label is not None],
        grips=[(joint.name, joint.grip) for joint in asset.joints if joint.grip is not None],
        behind=[(joint.name, joint.behind) for joint in asset.joints if joint.behind is not None],
        contract=asset.contract or "",
        behavior=asset.behavior.digest if asset.behavior is not None else "",
        states=[(s.name, state_cells(s.joint, s.value, *s.interval)) for s in asset.states],
    )


# Comparison -----------------------------------------------------------------------------------------------------------


class Difference(NamedTuple):
    """One cell of two tables.

    Attributes:
        size: by how much it differs; None if it is not a number. is_length: its size is in metres.
    """

    pointer: str
    size: float | None
    expected: object
    actual: object
    is_length: bool = False

    @property
    def problem(self) -> Problem:
        """Pointer and message; made only for differences that are reported, since nearly all cells agree."""
        return self.pointer, f"is {_formatted(self.actual)}, should be {_formatted(self.expected)}"

    def exceeds(self, tolerance: float) -> bool:
        """True if the cell differs by more than the tolerance, or is no number and differs."""
        return self.size is None or not self.size <= tolerance


def measured(cells: Iterable[Difference], tolerance: float) -> Measurement:
    """The largest of some differences, and a problem for each that exceeds the tolerance."""
    found = list(cells)
    worst = max((r.size for r in found if r.size is not None), default=0.0)
    return Measurement(worst, tuple(dict.fromkeys(r.problem for r in found if r.exceeds(tolerance))))


def compare(expected: Cells, actual: Cells, tolerance: float, length_m: float) -> list[Problem]:
    """One problem for each cell in which two tables, of assets or of scenes, differ by more than they may.

    Args:
        expected, actual: what it should be, and what it is.
        tolerance: of ratios, unit vectors, radians and of masses and moments relative to those of the body.
        length_m: tolerance of lengths, metres.
    """
    limits = {"gravity": 10 * tolerance, "fov_y_deg": ANGLE_TOLERANCE_DEG, "cone_deg": ANGLE_TOLERANCE_DEG}
    return [
        row.problem
        for row in differences(expected, actual)
        if row.exceeds(length_m if row.is_length else limits.get(row.pointer.rsplit("/", 1)[-1], tolerance))
    ]


def differences(expected: Cells, actual: Cells, at: str = "") -> Iterator[Difference]:
    """Every cell of two tables, row by row; cells that are no numbers only where they differ.

    Args:
        at: begins all pointers; ends in a slash.
    """
    yield from text(at.removesuffix("/"), sorted(expected), sorted(actual))
    for name in (name for name in expected if name in actual):
        one, other, pointer = expected[name], actual[name], f"{at}{name}"
        if isinstance(one, dict) and isinstance(other, dict):
            yield from differences(one, other, f"{pointer}/")
        elif isinstance(one, dict) or isinstance(other, dict):
            yield Difference(pointer, None, one and one["name"], other and other["name"])
        elif np.shape(one) != np.shape(other) or np.asarray(one).dtype.kind != "f":
            yield from text(pointer, one, other)
        else:
            yield _numbers(pointer, name, one, other, expected)


def text(at: str, expected: object, actual: object) -> Iterator[Difference]:
    """A cell that is no number, where it differs."""
    if expected != actual:
        yield Difference(at, None, expected, actual)


def _numbers(at: str, name: str, expected: Any, actual: Any, row: Cells) -> Difference:
    """A cell of numbers: the largest difference; of mass and inertia over those of the whole body.

    Args:
        row: that has the expected numbers.
    """
    a, b = np.ravel(np.asarray(expected, dtype=np.float64)), np.ravel(np.asarray(actual, dtype=np.float64))
    if name == "resistance":
        found = relative(at, a, b)
        return found if found.size is None or np.isfinite(found.size) else found._replace(size=None)
    if name == "quaternion" and float(a @ b) < 0:
        b = -b  # q and -q are one rotation; which of them is canonical can flip where w is near zero
    scale = expected if name == "mass" else sum(expected[:3]) if name == "inertia" else 1.0
    size = float(np.abs(a - b).max(initial=0.0)) / scale
    is_length = name in LENGTHS or (name == "range" and row["kind"] == JointKind.SLIDE)
    return Difference(at, size if np.isfinite(size) else None, a, b, is_length)


def relative(at: str, expected: np.ndarray, actual: np.ndarray) -> Difference:
    """A cell of numbers: the largest difference, each relative to the larger of its two numbers."""
    if expected.shape != actual.shape:
        return Difference(at, None, expected, actual)
    scale = np.maximum(np.maximum(np.abs(expected), np.abs(actual)), 1e-12)
    return Difference(at, float((np.abs(expected - actual) / scale).max(initial=0.0)), expected, actual)


def _formatted(values: object) -> str:
    """Text of a cell's value; rows of a table of numbers are separated by semicolons."""
    if not isinstance(values, np.ndarray):
        return str(values)
    return "; ".join(" ".join(f"{v:.6g}" for v in row) for row in np.atleast_2d(values))
