"""Asset record: links, joints, sites, named poses, labels, origin of one object; the signature that finds its like.

A rigid apple is an Asset with one link; a microwave is an Asset with joints. There is no subclass.
Frame of an asset: z up, x right, y back (a fixture faces -y), origin at the centre of its footprint on the ground.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from enum import StrEnum
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.asset.parts import (
    Collider,
    Drive,
    Exclusion,
    Inertial,
    Joint,
    JointKind,
    JointValue,
    Keyframe,
    Link,
    Region,
    Site,
    State,
    Visual,
)
from casa_assets.model.issue import Report
from casa_assets.model.pose import Pose
from casa_assets.model.record import BriefRecord, Id, Record, Sha256, Vec3
from casa_assets.model.registry.category import Portion, QCode

if TYPE_CHECKING:
    import mujoco
    import trimesh

__all__ = [
    "Asset", "Base", "Collider", "Drive", "Exclusion", "Inertial", "Joint", "JointKind", "JointValue", "Keyframe",
    "Labels", "Link", "Provenance", "Region", "Site", "State", "Visual",
]  # fmt: skip

Confidence = Annotated[float, Field(ge=0.0, le=1.0)]
TEST_SHARE = 5  # one in this many inputs is kept for testing
# Subject of the guess on an asset that probably has moving parts, none of which was found.
UNFOUND_PARTS = "moving_parts"
# Numbers per distribution: each is the mean of an equal share of the sorted values (a quantile function).
PAIR_SHARES, CENTER_SHARES, TONE_SHARES = 32, 16, 9
# Axes of colour: lightness, red-green, yellow-blue, and the two diagonals of the last two.
TONES = 5


class Split(StrEnum):
    """Dataset split of an instance: training or test."""

    TRAIN = "train"
    TEST = "test"


def split_of(sha256: str) -> Split:
    """Split of the asset made from an input with this digest, or of an object whose shape has this digest.

    It depends on nothing else, so that no instance changes its split when others are added or removed, or when it is
    made again.
    """
    return Split.TEST if int(sha256[:8], 16) % TEST_SHARE == 0 else Split.TRAIN


class Labels(BriefRecord):
    """Class labels of an asset, for segmentation and language.

    Attributes:
        category: id in registry/categories.yaml. classes: from the category upwards, such as (`mug`, `tableware`).
        qcode: Wikidata item and its certainty.
        split: `split_of` its input. For a procedural object, of its shape, so that two objects that differ only in
            colour are in the same split; None for fixtures and articulation.
        portion: portion of a cut object, or None for a whole one.
    """

    BLANKS = ("portion",)

    category: Id
    classes: tuple[Id, ...]
    qcode: QCode
    split: Split | None = None
    portion: Portion | None = None


class Guess(Record):
    """A decision that the source did not state.

    Attributes:
        subject: such as `scale` or `up_axis`. value: the decision, as text. confidence: 0..1. reason: the evidence.
    """

    subject: Id
    value: str
    confidence: Confidence
    reason: str


class Provenance(BriefRecord):
    """Origin of an asset: source, author, licence, digest, and the guesses that were made.

    Attributes:
        source: kind of source: folder, objaverse, objaverse_xl, text_to_3d, manifest, family.
        path: file, relative to the source's root.
        sha256: digest of the main source file and of all files that it refers to.
        title, author, licence, uri: as the source states them; licence is an SPDX id or `unknown`.
        uid: id within the source. prompt, generator: for generated meshes.
        node: name of the object within the file, for a file that was split; empty for a whole file.
        guesses: everything that was decided without being stated.
    """

    BLANKS = ("node",)

    source: Id
    path: str
    sha256: Sha256
    uid: str = ""
    title: str = ""
    author: str = ""
    licence: str = "unknown"
    uri: str = ""
    prompt: str = ""
    generator: str = ""
    node: str = ""
    guesses: tuple[Guess, ...] = ()

    @property
    def place(self) -> str:
        """The path, followed by `#` and the name of the object if the file was split."""
        return place_of(self.path, self.node)


def place_of(path: str, node: str) -> str:
    """A file, followed by `#` and the name of an object in it, unless the whole file is meant."""
    return f"{path}#{node}" if node else path


class ShapeDescriptor(Record):
    """Shape of a surface as numbers that do not change with rotation, translation or triangulation.

    Attributes:
        radius: root mean square distance of the surface from its centre, metres.
        pair_distances: distances between two points of the surface over `radius`, as means of equal shares, ascending.
        center_distances: distances of points from the centre, likewise.
        axis_spread: root mean square spread along the principal axes over `radius`, the widest first.
    """

    radius: Annotated[float, Field(gt=0.0)]
    pair_distances: Annotated[tuple[float, ...], Field(min_length=PAIR_SHARES, max_length=PAIR_SHARES)]
    center_distances: Annotated[tuple[float, ...], Field(min_length=CENTER_SHARES, max_length=CENTER_SHARES)]
    axis_spread: Vec3


class ColorHistogram(Record):
    """Distribution of the colours of a surface, by area.

    Attributes:
        tones: means of equal shares along each axis of colour in turn, CIELAB units.
        names: plain colour names, each with its share of the surface, the largest first.
        stated: whether the source has colours; readers fill in uniform light grey and white if it has none.
    """

    tones: Annotated[tuple[float, ...], Field(min_length=TONES * TONE_SHARES, max_length=TONES * TONE_SHARES)]
    names: tuple[tuple[str, float], ...]
    stated: bool


class Signature(Record):
    """Shape descriptor and colours of one object."""

    shape: ShapeDescriptor
    color: ColorHistogram


class Base(StrEnum):
    """Attachment of the root link to the world: free to move, or fixed in place."""

    FREE = "free"
    FIXED = "fixed"


class Asset(Record):
    """One simulation-ready object. Holds everything that the MJCF and USD writers need; they make no choices.

    Attributes:
        id: `<category>_<10 hex digits>`; equal ids mean identical bytes.
        links: parents before children; the first is the root and is called `object`.
        materials: visual materials, referenced by visuals. substances: physical materials, referenced by colliders.
        keyframes: named poses, `closed` first if there are any.
        behavior: its state machine, or None if it has no state other than that of its joints.
        contract: id of a file in registry/contracts, which the classes of a runtime read; None for loose objects.
    """

    id: Id
    base: Base = Base.FREE
    links: Annotated[tuple[Link, ...], Field(min_length=1)]
    joints: tuple[Joint, ...] = ()
    sites: tuple[Site, ...] = ()
    regions: tuple[Region, ...] = ()
    states: tuple[State, ...] = ()
    exclusions: tuple[Exclusion, ...] = ()
    keyframes: tuple[Keyframe, ...] = ()
    behavior: Behavior | None = None
    contract: Id | None = None
    materials: tuple[Material, ...] = ()
    substances: Annotated[tuple[Substance, ...], Field(min_length=1)]
    labels: Labels
    provenance: Provenance

    @model_validator(mode="after")
    def _references_are_sound(self) -> Self:
        seen: list[str] = []
        for i, link in enumerate(self.links):
            if (i == 0) != (link.parent is None) or (i == 0 and link.name != "object"):
                raise ValueError("the first link, and it alone, is the root and is called 'object'")
            if link.parent is not None and link.parent not in seen:
                raise ValueError(f"link {link.name!r}: parent {link.parent!r} must come before it")
            seen.append(link.name)
        visuals = [v.name for k in self.links for v in k.visuals]
        colliders = [c.name for k in self.links for c in k.colliders]
        _check_distinct("link", seen)
        _check_distinct("joint", [j.name for j in self.joints])
        _check_distinct("moved link", [j.child for j in self.joints])
        _check_distinct("visual or collider", visuals + colliders)
        _check_distinct("site or region", [s.name for s in self.sites] + [r.name for r in self.regions])
        _check_distinct("material", [m.id for m in self.materials])
        _check_distinct("substance", [s.id for s in self.substances])
        _check_ids("link", [j.child for j in self.joints], seen[1:])
        _check_ids("link", [s.link for s in self.sites] + [r.link for r in self.regions], seen)
        _check_ids("link", [name for e in self.exclusions for name in (e.first, e.second)], seen)
        _check_ids("joint", [s.joint for s in self.states], [j.name for j in self.joints])
        _check_distinct("keyframe", [k.name for k in self.keyframes])
        _check_ids("collider", [j.grip for j in self.joints if j.grip], colliders)
        ranges = {j.name: j.range for j in self.joints}
        _check_ids("joint", [j.behind for j in self.joints if j.behind], list(ranges))
        for key in self.keyframes:
            _check_ids("joint", [at.joint for at in key.joints], list(ranges))
            for at in key.joints:
                low, high = ranges[at.joint]
                if not low - 1e-9 <= at.value <= high + 1e-9:
                    raise ValueError(f"keyframe {key.name!r}: {at.joint} = {at.value} is outside {low}..{high}")
        if self.behavior:
            _check_ids("joint", list(self.behavior.joints), list(ranges))
            _check_ids("collider", list(self.behavior.contacts), colliders)
            known = [*(s.name for s in self.sites), *visuals, *(r.name for r in self.regions)]
            _check_ids("site, visual or region", [e.target for e in self.behavior.effects], known)
        _check_ids("material", [v.material for k in self.links for v in k.visuals], [m.id for m in self.materials])
        _check_ids("substance", [c.substance for k in self.links for c in k.colliders], [s.id for s in self.substances])
        return self

    @property
    def root(self) -> Link:
        """The link that carries all others."""
        return self.links[0]

    def link(self, name: str) -> Link:
        """Return the link of that name. Raises KeyError."""
        return {k.name: k for k in self.links}[name]

    def carried_by(self, roots: Collection[str]) -> frozenset[str]:
        """Names of some links and of all links that they carry."""
        found = set(roots)
        for link in self.links:  # parents come before what they carry
            if link.parent in found:
                found.add(link.name)
        return frozenset(found)

    def joint_of(self, link: str) -> Joint | None:
        """Return the joint that moves a link, or None if the link is the root or rigidly attached."""
        return {j.child: j for j in self.joints}.get(link)

    def asset_from_link(self, name: str, positions: Mapping[str, float] | None = None) -> Pose:
        """Pose of a link in the asset frame.

        Args:
            positions: joint positions, rad or m; joints that are not named are at zero. None: every joint is at zero.
        """
        link = self.link(name)
        if link.parent is None:
            return link.pose
        pose = self.asset_from_link(link.parent, positions) @ link.pose
        joint = self.joint_of(name)
        if positions is None:
            return pose
        return pose @ (Pose() if joint is None else joint.motion(positions.get(joint.name, 0.0)))

    def parent_from_link(self, name: str, positions: Mapping[str, float] | None = None) -> Pose:
        """Pose of a link in the frame of its parent link; for the root, in the asset frame.

        Args:
            positions: joint positions, rad or m; joints that are not named are at zero. None: every joint is at zero.
        """
        joint, pose = self.joint_of(name), self.link(name).pose
        return pose if joint is None else pose @ joint.motion((positions or {}).get(joint.name, 0.0))

    def is_moved(self, name: str) -> bool:
        """True if a link is moved by any joint, its own or one of a link that carries it."""
        parent = self.link(name).parent
        return self.joint_of(name) is not None or (parent is not None and self.is_moved(parent))

    def substance(self, name: str) -> Substance:
        """Return the substance of that id. Raises KeyError."""
        return {s.id: s for s in self.substances}[name]

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return sum(k.inertial.mass for k in self.links)

    @property
    def center_of_mass(self) -> npt.NDArray[np.float64]:
        """(3,) centre of mass, asset frame, joints at zero, metres."""
        masses = np.array([k.inertial.mass for k in self.links])
        centers = [self.asset_from_link(k.name).apply(np.array([k.inertial.center_of_mass]))[0] for k in self.links]
        found: npt.NDArray[np.float64] = masses @ np.array(centers) / masses.sum()
        return found

    @cached_property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) lower and upper corner of all visuals, asset frame, joints at zero, metres; read-only."""
        points = [self.asset_from_link(k.name).apply(v.mesh.vertices) for k in self.links for v in k.visuals]
        stacked = np.concatenate(points)
        corners = np.array([stacked.min(axis=0), stacked.max(axis=0)])
        corners.setflags(write=False)
        return corners

    # For users. Writers, checks and viewers use this module, so what they need is imported when it is called.

    def to_mjspec(self) -> mujoco.MjSpec:
        """Return an MjSpec of its body `object` alone, without a floor and a free joint, to attach to a kitchen.

        `spec.attach(it, frame=..., prefix=...)` takes its meshes and pictures along; after `frame.attach_body(...)`,
        which does not, `spec.assets.update(it.assets)` adds them.
        """
        return _actions().to_mjspec(self)

    def to_mjmodel(self) -> mujoco.MjModel:
        """Return a compiled model of the asset on a floor, free to move unless its base is fixed."""
        return _actions().to_mjmodel(self)

    def to_trimesh(self, what: Literal["visual", "collision"] = "visual") -> trimesh.Scene:
        """Return its visual meshes or its collision shapes; metres, z up, every joint at zero.

        There is a node per link, and below it a geometry for each visual or collider, with its name.
        """
        scene: trimesh.Scene = _actions().to_trimesh(self, what)
        return scene

    def write(self, folder: str | Path) -> Path:
        """Write MJCF and USD with a picture, and `asset.json`, which `casa_assets.load` reads back.

        Args:
            folder: created if missing.
        Returns:
            `<folder>/<id of the asset>`, which is overwritten if it exists.
        Raises:
            OutputError: the folder cannot be written to, or another run is writing to it.
        """
        written: Path = _actions().write(self, folder)
        return written

    def check(self) -> Report:
        """Run every check that applies, on the files that `write` would write; takes about a second."""
        report: Report = _actions().check(self)
        return report

    def show(self, pose: str = "", web: bool = False) -> None:
        """Show it until the window is closed, or until Ctrl-C ends the page.

        Args:
            pose: keyframe to begin in, such as `open`.
            web: serve a page for the browser even if there is a screen for MuJoCo's viewer.
        """
        _actions().show(self, pose, web)


def _actions() -> Any:
    """The functions of users on assets.

    The module is not named in one piece: else the keys of all that uses assets would count it (`cache_key.py`).
    Nothing that is kept in a cache is made with these methods.
    """
    return import_module(".api.assets", "casa_assets")


def _check_distinct(kind: str, names: list[str]) -> None:
    repeated = sorted({n for n in names if names.count(n) > 1})
    if repeated:
        raise ValueError(f"{kind} {repeated[0]!r} occurs twice")


def _check_ids(kind: str, used: list[str], defined: list[str]) -> None:
    missing = sorted(set(used) - set(defined))
    if missing:
        raise ValueError(f"no {kind} {missing[0]!r}; there are {sorted(defined)}")
