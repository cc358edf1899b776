"""Asset record: links, joints, sites, regions, named poses, labels and provenance of one thing.

A rigid apple is an Asset with one link; a microwave is an Asset with joints. There is no subclass.
Frame of an asset: z up, x right, y back (a fixture faces -y), origin at the centre of its footprint on the ground.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.asset.joint import Drive, Exclusion, Joint, JointKind, JointValue, Keyframe, State
from casa_assets.model.asset.link import Collider, Inertial, Link, Visual
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.asset.provenance import Labels, Provenance
from casa_assets.model.asset.site import Region, Site
from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, Record

__all__ = [
    "Asset",
    "Base",
    "Collider",
    "Drive",
    "Exclusion",
    "Inertial",
    "Joint",
    "JointKind",
    "JointValue",
    "Keyframe",
    "Link",
    "Region",
    "Site",
    "State",
    "Visual",
]


class Base(StrEnum):
    """Attachment of the root link to the world: free to move, or welded where it is placed."""

    FREE = "free"
    FIXED = "fixed"


class Asset(Record):
    """One simulation-ready thing. Holds everything that the MJCF and USD writers need; they choose nothing.

    Attributes:
        id: `<category>_<10 hex digits>`; the same id is the same bytes.
        links: parents before children; the first is the root and is called `object`.
        materials: looks, referenced by visuals. substances: matter, referenced by colliders.
        keyframes: named poses, `closed` first where there are any.
        behavior: its state machine, None where nothing about it changes but where its joints stand.
        contract: id in registry/contracts of what a runtime expects of it, None for loose objects.
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
    def _whole(self) -> Self:
        seen: list[str] = []
        for i, link in enumerate(self.links):
            if (i == 0) != (link.parent is None) or (i == 0 and link.name != "object"):
                raise ValueError("the first link, and it alone, is the root and is called 'object'")
            if link.parent is not None and link.parent not in seen:
                raise ValueError(f"link {link.name!r}: parent {link.parent!r} must come before it")
            seen.append(link.name)
        visuals = [v.name for k in self.links for v in k.visuals]
        colliders = [c.name for k in self.links for c in k.colliders]
        _distinct("link", seen)
        _distinct("joint", [j.name for j in self.joints])
        _distinct("moved link", [j.child for j in self.joints])
        _distinct("visual or collider", visuals + colliders)
        _distinct("site or region", [s.name for s in self.sites] + [r.name for r in self.regions])
        _distinct("material", [m.id for m in self.materials])
        _distinct("substance", [s.id for s in self.substances])
        _known("link", [j.child for j in self.joints], seen[1:])
        _known("link", [s.link for s in self.sites] + [r.link for r in self.regions], seen)
        _known("link", [name for e in self.exclusions for name in (e.first, e.second)], seen)
        _known("joint", [s.joint for s in self.states], [j.name for j in self.joints])
        _distinct("keyframe", [k.name for k in self.keyframes])
        _known("collider", [j.grip for j in self.joints if j.grip], colliders)
        ranges = {j.name: j.range for j in self.joints}
        _known("joint", [j.behind for j in self.joints if j.behind], list(ranges))
        for key in self.keyframes:
            _known("joint", [at.joint for at in key.joints], list(ranges))
            for at in key.joints:
                low, high = ranges[at.joint]
                if not low - 1e-9 <= at.value <= high + 1e-9:
                    raise ValueError(f"keyframe {key.name!r}: {at.joint} = {at.value} is outside {low}..{high}")
        if self.behavior:
            sites = [s.name for s in self.sites]
            _known("joint", list(self.behavior.joints), list(ranges))
            _known("collider", list(self.behavior.contacts), colliders)
            _known(
                "site, visual or region", list(self.behavior.targets), sites + visuals + [r.name for r in self.regions]
            )
        _known("material", [v.material for k in self.links for v in k.visuals], [m.id for m in self.materials])
        _known("substance", [c.substance for k in self.links for c in k.colliders], [s.id for s in self.substances])
        return self

    @property
    def root(self) -> Link:
        """The link that carries all others."""
        return self.links[0]

    def link(self, name: str) -> Link:
        """The link of that name. Raises KeyError."""
        return {k.name: k for k in self.links}[name]

    def joint_of(self, link: str) -> Joint | None:
        """The joint that moves a link, or None where it is the root or rigidly attached."""
        return {j.child: j for j in self.joints}.get(link)

    def asset_from_link(self, name: str) -> Pose:
        """Pose of a link in the asset frame, every joint at zero."""
        link = self.link(name)
        return link.pose if link.parent is None else self.asset_from_link(link.parent) @ link.pose

    def substance(self, name: str) -> Substance:
        """The substance of that id. Raises KeyError."""
        return {s.id: s for s in self.substances}[name]

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return sum(k.inertial.mass for k in self.links)

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) corners of everything that is seen, asset frame, joints at zero, metres."""
        points = [self.asset_from_link(k.name).apply(v.mesh.vertices) for k in self.links for v in k.visuals]
        cloud = np.concatenate(points)
        return np.array([cloud.min(axis=0), cloud.max(axis=0)])


def _distinct(kind: str, names: list[str]) -> None:
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ValueError(f"{kind} {twice[0]!r} occurs twice")


def _known(kind: str, wanted: list[str], known: list[str]) -> None:
    missing = sorted(set(wanted) - set(known))
    if missing:
        raise ValueError(f"no {kind} {missing[0]!r}; there are {sorted(known)}")
