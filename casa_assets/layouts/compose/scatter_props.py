"""Scatter small objects on worktops and shelves: along the wall, clear of objects that are already there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import rng_for
from casa_assets.layouts.compose.compose import box_in_world, pose_at_spot
from casa_assets.layouts.order.build_order import DepthReference, OrderItem, Spot
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan.wall_frame import WallFrame
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.pose import Pose

Box = npt.NDArray[np.float64]  # (2, 3) lower and upper corner, metres, frame of the room

MIN_GAP_M = 0.025  # between props
WALL_GAP_M = 0.05
SET_DOWN_GAP_M = 0.0008  # over the surface
# A shorter worktop is left free; a longer one has at most one prop per this length.
MIN_STRETCH_M, STRETCH_PER_PROP_M = 0.5, 0.9
MAX_ON_WORKTOPS, MAX_ON_SHELVES, MAX_PER_SHELF = 5, 5, 2
MAX_TRIES = 24
# The worktop beside these appliances stays free, for what is put in and taken out, and beside all that stands on it and
# has something to be moved, for the hand that does it.
APPLIANCES = ("range", "hob", "microwave", "coffee_machine", "toaster_oven", "blender", "stand_mixer")
FREE_BESIDE_M = 0.36
RANDOM_LANE = "scene/props"


@dataclass(frozen=True)
class SupportSurface:
    """A worktop or shelf board: pose of the centre of its upper face in the room, size, and free height, metres."""

    name: str
    pose: Pose
    width: float
    depth: float
    height: float
    is_shelf: bool


def scatter_props(
    kitchen: KitchenRequest, assets: Mapping[str, Asset], props: Sequence[tuple[PresetChoice, Asset]], seed: int = 0
) -> tuple[tuple[OrderItem, Asset], ...]:
    """Choose props and free places for them on the worktops and shelves of a kitchen.

    `assets`: by name of the ordered item. `props`: presets that the style scatters, the likeliest first.
    """
    rng = rng_for(seed, f"{RANDOM_LANE}/{kitchen.plan.id}/{kitchen.style.id}")
    bounds = {
        item.name: box_in_world(pose_at_spot(assets[item.name], item.spot), assets[item.name].bounds)
        for item in kitchen.items
    }
    occupied = [bounds[item.name] for item in kitchen.items if item.layer == "things"]
    beside = np.array([[-FREE_BESIDE_M, -FREE_BESIDE_M, -9.0], [FREE_BESIDE_M, FREE_BESIDE_M, 9.0]])
    kept_free = [
        bounds[item.name] + beside
        for item in kitchen.items
        if item.role in APPLIANCES or (item.layer == "things" and assets[item.name].joints)
    ]
    out: list[tuple[OrderItem, Asset]] = []
    queue = list(props)
    counts: dict[str, int] = {}
    on_worktops = on_shelves = 0
    surfaces = list(_surfaces(kitchen, assets))
    surfaces = [surfaces[int(k)] for k in rng.permutation(len(surfaces))]
    for surface in surfaces:
        room = MAX_ON_SHELVES - on_shelves if surface.is_shelf else MAX_ON_WORKTOPS - on_worktops
        share = MAX_PER_SHELF if surface.is_shelf else max(1, int(surface.width / STRETCH_PER_PROP_M))
        for _ in range(min(room, share)):
            found = _put(surface, queue, occupied if surface.is_shelf else occupied + kept_free, rng)
            if found is None:
                break
            index, spot, box = found
            choice, asset = queue.pop(index)
            queue.append((choice, asset))  # it comes again after all others
            counts[choice.family] = counts.get(choice.family, 0) + 1
            name = f"prop_{choice.family}_{counts[choice.family]}"
            out.append((OrderItem(name, "prop", choice, spot), asset))
            occupied.append(box)
            on_shelves += surface.is_shelf
            on_worktops += not surface.is_shelf
    return tuple(out)


def _surfaces(kitchen: KitchenRequest, assets: Mapping[str, Asset]) -> Iterator[SupportSurface]:
    for item in kitchen.items:
        if item.role not in ("counter", "shelf", "larder"):
            continue
        asset = assets[item.name]
        pose = pose_at_spot(asset, item.spot)
        for region in asset.regions:
            is_shelf = region.name.startswith("level")
            if region.link != asset.root.name or not (is_shelf or region.name.startswith("top")):
                continue
            width, depth, height = region.size
            if not is_shelf and (width < MIN_STRETCH_M or depth < 0.4):
                continue
            low = pose @ asset.root.pose @ region.pose @ Pose(position=(0.0, 0.0, -height / 2))
            yield SupportSurface(f"{item.name}/{region.name}", low, width, depth, height, is_shelf)


def _put(
    surface: SupportSurface,
    props: Sequence[tuple[PresetChoice, Asset]],
    occupied: Sequence[Box],
    rng: np.random.Generator,
) -> tuple[int, Spot, Box] | None:
    """Index of the first prop that fits in a free place, its spot and its bounds."""
    lower, upper = np.reshape([*occupied], (-1, 2, 3)).transpose(1, 0, 2)
    for index, (_, asset) in enumerate(props):
        low, high = asset.bounds
        reach = np.hypot(*np.maximum(np.abs(low[:2]), np.abs(high[:2])))
        tall = float(high[2] - low[2])
        if tall > surface.height - 0.02 or 2 * reach > min(surface.width, surface.depth) + 0.04:
            continue
        for _ in range(MAX_TRIES):
            turn = float(rng.integers(-14, 15))
            half = _half_extents(asset, turn)
            side = surface.width / 2 - half[0] - 0.02
            if side <= 0:
                break
            x = float(rng.uniform(-side, side))
            back = surface.depth / 2 - half[1] - (0.01 if surface.is_shelf else WALL_GAP_M)
            y = 0.0 if surface.is_shelf else back - float(rng.uniform(0.0, 0.04))
            if back <= -surface.depth / 2 + half[1]:
                break
            spot = _spot(surface, x, y, turn)
            box = box_in_world(pose_at_spot(asset, spot), asset.bounds)
            # Closer than the gap to one of the others; one may rest on another.
            apart = np.array([MIN_GAP_M, MIN_GAP_M, -0.002])
            if not ((box[0] < upper + apart) & (lower < box[1] + apart)).all(axis=1).any():
                return index, spot, box
    return None


def _spot(surface: SupportSurface, x: float, y: float, turn: float) -> Spot:
    """A spot on a surface; the thing faces as the surface does."""
    px, py, pz = (float(c) for c in surface.pose.apply(np.array([[x, y, SET_DOWN_GAP_M]]))[0])
    along = surface.pose.rotation[:, 0]
    turn_deg = round(math.degrees(math.atan2(float(along[1]), float(along[0]))), 4) % 360.0
    quarters, more = divmod(turn_deg, 90.0)
    frame = WallFrame(round(px, 4), round(py, 4), int(quarters), more)
    return Spot(frame, 0.0, 0.0, round(pz, 5), turn, DepthReference.MIDDLE)


def _half_extents(asset: Asset, turn: float) -> npt.NDArray[np.float64]:
    """Half the width and depth of the bounds of an asset that is turned by degrees."""
    low, high = asset.bounds
    w, d = np.maximum(np.abs(low[:2]), np.abs(high[:2]))
    a = math.radians(turn)
    c, s = abs(math.cos(a)), abs(math.sin(a))
    return np.array([w * c + d * s, w * s + d * c])
