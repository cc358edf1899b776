"""Derive the floor plan (KitchenFacts) of a composed kitchen, for checks of design, reach and tasks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from casa_assets.core.numeric import decimals
from casa_assets.layouts.compose import AssetOutlines, box_of, door_leaf_widths
from casa_assets.layouts.order.build_order import KitchenRequest, OrderItem
from casa_assets.layouts.order.request import placed_run, placed_wall
from casa_assets.layouts.plan.clearances import find_aisles
from casa_assets.layouts.plan.room import WallHole
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.kitchen.floor import (
    Fixture,
    FixtureJoint,
    FixtureRegion,
    FixtureSite,
    Footprint,
    KitchenFacts,
    Role,
    WallOpening,
)
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import Layer, Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Role of an ordered item -> role of the fixture; items that are not listed get theirs from their position.
ROLES = {
    **{r.value: r for r in Role if r not in (Role.ISLAND, Role.CORNER)},
    "counter": Role.WORKTOP,
    "island": Role.WORKTOP,
    "stool": Role.SEAT,
    "chair": Role.SEAT,
    "lamp": Role.HUNG,
    **dict.fromkeys(("filler", "panel", "backsplash", "cornice", "skirting", "splash"), Role.TRIM),
}
BASE_ROLES = {"drawer_stack": Role.DRAWERS, "island_base": Role.ISLAND}
WORKTOP_FROM_M, WORKTOP_TO_M = 0.85, 1.15  # heights of the foot of what stands on a worktop
FLOOR_TO_M = 0.1  # height of the foot of what stands on the floor


def facts_of(kitchen: KitchenRequest, scene: Scene) -> KitchenFacts:
    """Floor plan of a kitchen and of the scene that was composed of it; objects put into it are no fixtures."""
    items = {item.name: item for item in kitchen.items}
    assets = scene.asset_of
    ordered = [p for p in scene.placements if p.resting is None]
    kept = {p.asset for p in ordered}
    outlines = {a.id: AssetOutlines(a) for a in scene.assets if a.id in kept}
    fixtures = tuple(_fixture(p, assets[p.name], items[p.name], outlines) for p in ordered)
    by_name = {f.name: f for f in fixtures}
    walls = tuple(placed_wall(w, is_open=f"wall_{w.id}" not in items) for w in kitchen.room.walls)
    fronts = _fronts(kitchen, fixtures)
    rows = tuple(placed_run(line, kitchen.slots[name], fronts) for name, line in kitchen.lines.items())
    outline = kitchen.room.outline
    closed = {w.id for w in walls if not w.is_open}
    # Nobody goes through a niche, nor through a window in its back.
    holes = [h for h in kitchen.holes if h.wall.id in closed and not h.is_niche]
    return KitchenFacts(
        id=scene.id,
        plan=kitchen.plan.id,
        compact=kitchen.plan.compact,
        all_tasks=kitchen.plan.all_tasks,
        outline=outline,
        height=kitchen.room.height,
        walls=walls,
        openings=tuple(_opening(h, assets.get(h.opening.id), by_name.get(h.opening.id)) for h in holes),
        runs=rows,
        fixtures=fixtures,
        aisles=find_aisles(rows, walls, outline, {c.column.id: c.outline for c in kitchen.room.columns}),
    )


def _role(item: OrderItem, place: Placement, asset: Asset, low: float) -> Role:
    if item.role == "column":
        return Role.ON_FLOOR
    if place.layer is not Layer.THINGS:
        return Role.ROOM
    if item.role == "base":
        return BASE_ROLES.get(asset.labels.category, Role.CABINET)
    if item.role == "corner":
        return Role.UPPER if low > 1.0 else Role.CORNER
    if item.role in ROLES:
        return ROLES[item.role]
    if low < FLOOR_TO_M:
        return Role.ON_FLOOR
    return Role.THING if asset.base is Base.FREE and WORKTOP_FROM_M < low < WORKTOP_TO_M else Role.HUNG


def _fixture(place: Placement, asset: Asset, item: OrderItem, outlines: Mapping[str, AssetOutlines]) -> Fixture:
    middle, size = box_of(asset)
    x, y, z = _at(place.pose, middle)
    footprint = Footprint(center=(_rounded(x), _rounded(y)), size=(size[0], size[1]), yaw=_yaw(place.pose))
    low, high = _rounded(z - size[2] / 2), _rounded(z + size[2] / 2)
    own = outlines[asset.id]
    role = _role(item, place, asset, low)
    return Fixture(
        name=place.name,
        role=role,
        category=asset.labels.category,
        unit=item.unit,
        run=item.run,
        footprint=footprint,
        bottom=low,
        top=high,
        joints=tuple(_joints(place, asset, own, footprint)),
        regions=tuple(_regions(place, asset, own)),
        sites=tuple(_site(s.name, place.pose @ own.poses[s.link] @ s.pose) for s in asset.sites),
        buttons=tuple(
            _site(c.name, place.pose @ own.poses[k.name] @ c.pose)
            for k in asset.links
            for c in k.colliders
            if c.label == "button" or "button" in c.name
        ),
    )


def _site(name: str, pose: Pose) -> FixtureSite:
    return FixtureSite(name=name, position=_at(pose, (0.0, 0.0, 0.0)))


def _joints(place: Placement, asset: Asset, outlines: AssetOutlines, footprint: Footprint) -> Iterator[FixtureJoint]:
    for joint in asset.joints:
        grip = outlines.grip_point(joint)
        yield FixtureJoint(
            name=joint.name,
            kind=joint.kind,
            range=joint.range,
            behind=joint.behind,
            grip_point=None if grip is None else _at(place.pose, grip),
            swept_area=outlines.swept_area(joint, place.pose, footprint),
        )


def _regions(place: Placement, asset: Asset, outlines: AssetOutlines) -> Iterator[FixtureRegion]:
    for region in asset.regions:
        pose = place.pose @ outlines.poses[region.link] @ region.pose
        (x, y, z), (w, d, h) = pose.position, region.size
        yield FixtureRegion(
            name=region.name,
            footprint=Footprint(center=(_rounded(x), _rounded(y)), size=(w, d), yaw=_yaw(pose)),
            bottom=_rounded(z - h / 2),
            top=_rounded(z + h / 2),
            is_moving=region.link != asset.root.name,
        )


def _opening(hole: WallHole, asset: Asset | None, fixture: Fixture | None) -> WallOpening:
    frame, opening = hole.wall.frame, hole.opening
    clear_width, swept_area = hole.right - hole.left, None
    if opening.kind is OpeningKind.DOOR and asset is not None and fixture is not None:
        for joint, placed in zip(asset.joints, fixture.joints, strict=True):
            if placed.swept_area is not None:
                width, obstructed = door_leaf_widths(asset, joint)
                clear_width, swept_area = width - obstructed, placed.swept_area
    return WallOpening(
        id=opening.id,
        kind=opening.kind,
        wall=hole.wall.id,
        start=frame.at(hole.left, 0.0)[:2],
        end=frame.at(hole.right, 0.0)[:2],
        bottom=hole.bottom,
        top=hole.top,
        clear_width=round(clear_width, 4),
        can_open=asset is not None and bool(asset.joints),
        leads_out=opening.closet is None,
        swept_area=swept_area,
    )


def _fronts(kitchen: KitchenRequest, fixtures: Iterable[Fixture]) -> dict[str, float]:
    """Unit -> distance from the line of its run to the foremost front of fixtures on the floor in its place, metres."""
    lines = {slot.name: slot.line for row in kitchen.slots.values() for slot in row}
    out: dict[str, float] = {}
    for fixture in fixtures:
        if fixture.bottom < 0.3 and fixture.unit in lines:
            front = lines[fixture.unit].frame.to_local(*fixture.footprint.at(0.0, 0.0))[1]
            out[fixture.unit] = max(front, out.get(fixture.unit, 0.0))
    return out


def _yaw(pose: Pose) -> float:
    """Turn to the left of an upright pose, radians."""
    w, _, _, z = pose.quaternion
    return round(2.0 * math.atan2(z, w), 9)


def _at(pose: Pose, point: Vec3) -> Vec3:
    x, y, z = map(_rounded, pose.apply(np.array([point]))[0])
    return (x, y, z)


def _rounded(value: float) -> float:
    return decimals(float(value), 4)
