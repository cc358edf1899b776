"""Scatter small objects on worktops and shelves: along the wall, clear of what stands there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.core.sampling import rng_for
from casa_assets.layouts.compose.compose import pose_at_spot
from casa_assets.layouts.order.build_order import DepthReference, OrderItem, Spot
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.plan.wall_frame import WallFrame
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.model.pose import Pose

Box = npt.NDArray[np.float64]  # (2, 3) least and greatest corner, metres, frame of the room

MIN_GAP_M = 0.025  # metres between things
FROM_WALL = 0.05
ON_TOP = 0.0008
# Worktops: a stretch shorter than this is left free, and so much of it carries at most one thing.
MIN_STRETCH_M, STRETCH_PER_ITEM_M = 0.5, 0.9
MOST_ON_TOPS, MOST_ON_SHELVES, MOST_ON_ONE = 5, 5, 2
MAX_TRIES = 24
# Beside these the worktop is where one puts down what goes in or comes out; nothing is scattered there.
WORKED_AT, WORKED_M = ("range", "hob", "microwave", "coffee_machine"), 0.36
RANDOM_LANE = "scene/props"


@dataclass(frozen=True)
class SupportSurface:
    """A place to put things on, in the room: middle of its top, along and back unit vectors, size, free height."""

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

    Args:
        assets: of all that is wanted, by name. props: members that the style scatters, the likeliest first.
        seed: another seed, another arrangement.
    """
    rng = rng_for(seed, f"{RANDOM_LANE}/{kitchen.plan.id}/{kitchen.style.id}")
    taken = [
        _bounds(assets[w.name], pose_at_spot(assets[w.name], w.spot)) for w in kitchen.items if w.layer == "things"
    ]
    worked = [
        _bounds(assets[w.name], pose_at_spot(assets[w.name], w.spot)) for w in kitchen.items if w.role in WORKED_AT
    ]
    kept = [np.array([box[0] - (WORKED_M, WORKED_M, 9.0), box[1] + (WORKED_M, WORKED_M, 9.0)]) for box in worked]
    out: list[tuple[OrderItem, Asset]] = []
    waiting = list(props)
    counts: dict[str, int] = {}
    on_tops = on_shelves = 0
    surfaces = list(_surfaces(kitchen, assets))
    surfaces = [surfaces[int(k)] for k in rng.permutation(len(surfaces))]
    for surface in surfaces:
        room = MOST_ON_SHELVES - on_shelves if surface.is_shelf else MOST_ON_TOPS - on_tops
        share = MOST_ON_ONE if surface.is_shelf else max(1, int(surface.width / STRETCH_PER_ITEM_M))
        for _ in range(min(room, share)):
            found = _put(surface, waiting, taken if surface.is_shelf else taken + kept, rng)
            if found is None:
                break
            index, spot, box = found
            choice, asset = waiting.pop(index)
            waiting.append((choice, asset))  # it may come again when all others have been
            counts[choice.family] = counts.get(choice.family, 0) + 1
            name = f"prop_{choice.family}_{counts[choice.family]}"
            out.append((OrderItem(name, "prop", choice, spot), asset))
            taken.append(box)
            on_shelves += surface.is_shelf
            on_tops += not surface.is_shelf
    return tuple(out)


def _surfaces(kitchen: KitchenRequest, assets: Mapping[str, Asset]) -> Iterator[SupportSurface]:
    for wanted in kitchen.items:
        if wanted.role not in ("counter", "shelf"):
            continue
        asset = assets[wanted.name]
        pose = pose_at_spot(asset, wanted.spot)
        for region in asset.regions:
            shelf = region.name.startswith("level")
            if region.link != asset.root.name or not (shelf or region.name.startswith("top")):
                continue
            width, depth, height = region.size
            if not shelf and (width < MIN_STRETCH_M or depth < 0.4):
                continue
            low = pose @ asset.root.pose @ region.pose @ Pose(position=(0.0, 0.0, -height / 2))
            yield SupportSurface(f"{wanted.name}/{region.name}", low, width, depth, height, shelf)


def _put(
    surface: SupportSurface, props: Sequence[tuple[PresetChoice, Asset]], taken: Sequence[Box], rng: np.random.Generator
) -> tuple[int, Spot, Box] | None:
    """The first of the props that finds a free place, the place, and what it takes up."""
    for index, (_, asset) in enumerate(props):
        low, high = asset.bounds
        reach = np.hypot(*np.maximum(np.abs(low[:2]), np.abs(high[:2])))
        tall = float(high[2] - low[2])
        if tall > surface.height - 0.02 or 2 * reach > min(surface.width, surface.depth) + 0.04:
            continue
        for _ in range(MAX_TRIES):
            turn = float(rng.integers(-14, 15))
            half = _half(asset, turn)
            side = surface.width / 2 - half[0] - 0.02
            if side <= 0:
                break
            x = float(rng.uniform(-side, side))
            back = surface.depth / 2 - half[1] - (0.01 if surface.is_shelf else FROM_WALL)
            y = 0.0 if surface.is_shelf else back - float(rng.uniform(0.0, 0.04))
            if back <= -surface.depth / 2 + half[1]:
                break
            spot = _spot(surface, x, y, turn)
            box = _bounds(asset, pose_at_spot(asset, spot))
            if not any(_meet(box, other) for other in taken):
                return index, spot, box
    return None


def _spot(surface: SupportSurface, x: float, y: float, turn: float) -> Spot:
    """A spot on a surface; the thing faces as the surface does."""
    px, py, pz = (float(c) for c in surface.pose.apply(np.array([[x, y, ON_TOP]]))[0])
    along = surface.pose.rotation[:, 0]
    quarter = round(math.atan2(float(along[1]), float(along[0])) / (math.pi / 2)) % 4
    frame = WallFrame(round(px, 4), round(py, 4), quarter)
    return Spot(frame, 0.0, 0.0, round(pz, 5), turn, DepthReference.MIDDLE)


def _half(asset: Asset, turn: float) -> npt.NDArray[np.float64]:
    """Half the width and depth of a thing that is turned by degrees."""
    low, high = asset.bounds
    w, d = np.maximum(np.abs(low[:2]), np.abs(high[:2]))
    a = math.radians(turn)
    c, s = abs(math.cos(a)), abs(math.sin(a))
    return np.array([w * c + d * s, w * s + d * c])


def _bounds(asset: Asset, pose: Pose) -> Box:
    low, high = asset.bounds
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    points = pose.apply(corners)
    return np.array([points.min(axis=0), points.max(axis=0)])


def _meet(a: Box, b: Box) -> bool:
    """True if two boxes come nearer than things should; one may stand on the other."""
    apart = np.array([MIN_GAP_M, MIN_GAP_M, -0.002])
    return bool((a[0] < b[1] + apart).all() and (b[0] < a[1] + apart).all())
