"""Colliders and regions of a link -> separate nodes, each in a layer that a viewer shows or hides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from casa_assets.export.gltf.number import placed, rounded
from casa_assets.export.gltf.visual import Meshes
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Collider, Link, Region
from casa_assets.model.asset.shape import Box, Capsule, Cylinder, Hull, MeshShape, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

STEPS = 24  # corners of a circle


class LayerName(StrEnum):
    """Value of `extras.layer` of a node that shows something."""

    VISUAL = "visual"
    OUTSIDE = "outside"  # faces of walls that look out of the room; a viewer leaves them out, to look in
    CEILING = "ceiling"  # likewise
    COLLIDER = "collider"
    REGION = "region"


@dataclass(frozen=True)
class Layers:
    """Layers of a file in addition to the visuals: collision shapes, regions. A viewer hides both at first."""

    colliders: bool = False
    regions: bool = False


SEEN_ALONE, EVERYTHING = Layers(), Layers(colliders=True, regions=True)


# Linear RGBA; colliders take these in turn, so that neighbours are told apart.
COLLIDER_COLORS = (
    (0.90, 0.20, 0.12, 0.55),
    (0.08, 0.42, 0.75, 0.55),
    (0.95, 0.62, 0.05, 0.55),
    (0.12, 0.55, 0.22, 0.55),
    (0.48, 0.20, 0.70, 0.55),
    (0.02, 0.55, 0.58, 0.55),
)
REGION_COLOR = (0.05, 0.65, 0.30, 0.22)


def nodes(link: Link, regions: tuple[Region, ...], meshes: Meshes, wanted: Layers) -> Iterator[dict[str, Any]]:
    """Yield a node for each collider and region of a link, if they are wanted.

    Args:
        regions: all regions of the asset.
    """
    if wanted.colliders:
        for number, collider in enumerate(link.colliders):
            yield _collider(collider, number, meshes)
    if wanted.regions:
        for region in regions:
            if region.link == link.name:
                yield _region(region, meshes)


def _collider(collider: Collider, number: int, meshes: Meshes) -> dict[str, Any]:
    turn = number % len(COLLIDER_COLORS)
    material = meshes.materials.plain(f"collider_{turn}", COLLIDER_COLORS[turn])
    extras = {
        "layer": LayerName.COLLIDER.value,
        "collider": {"name": collider.name, "kind": collider.shape.kind, "substance": collider.substance},
    }
    return {"name": collider.name, "extras": extras, **_shown(collider.shape, collider.pose, meshes, material)}


def _region(region: Region, meshes: Meshes) -> dict[str, Any]:
    material = meshes.materials.plain("region", REGION_COLOR)
    width, depth, height = region.size
    # A cylinder whose box is not square is an ellipse; the scale of its node makes it one.
    shape: Shape = Box(size=region.size) if region.kind == "box" else Cylinder(radius=0.5, height=1.0)
    shown = _shown(shape, region.pose, meshes, material)
    if region.kind == "cylinder":
        shown["scale"] = rounded((width / 2, depth / 2, height))
    extras = {"layer": LayerName.REGION.value, "region": {"name": region.name, "kind": region.kind}}
    return {"name": region.name, "extras": extras, **shown}


def _shown(shape: Shape, pose: Pose, meshes: Meshes, material: int) -> dict[str, Any]:
    """Mesh, pose and scale of a shape: primitives share one mesh of unit size, scaled by their nodes."""
    unit, scale = _unit(shape)
    points, faces = tessellate(unit, Pose(), STEPS)
    used = np.unique(faces)
    mesh = meshes.bare(points[used], np.searchsorted(used, faces), material)
    sized = {} if scale == (1.0, 1.0, 1.0) else {"scale": rounded(scale)}
    return {"mesh": mesh, **placed(pose), **sized}


def _unit(shape: Shape) -> tuple[Shape, Vec3]:
    """A shape of unit size, and the scale that turns it into the given one."""
    if isinstance(shape, Box):
        return Box(size=(1.0, 1.0, 1.0)), shape.size
    if isinstance(shape, Sphere):
        return Sphere(radius=1.0), (shape.radius, shape.radius, shape.radius)
    if isinstance(shape, Cylinder):
        return Cylinder(radius=1.0, height=1.0), (shape.radius, shape.radius, shape.height)
    assert isinstance(shape, Capsule | Hull | MeshShape)
    return shape, (1.0, 1.0, 1.0)
