"""Find the places of an asset that hold things: regions, niches and slots, and burners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from casa_assets.articulate.plan import round_mm, round_mm_vec3
from casa_assets.articulate.segment.fragments import joined_meshes
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, TOP, DepthImage, outline_area, render_depth
from casa_assets.core.numeric import Floats, Mask
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.surface import connected_groups
from casa_assets.model.asset.asset import Asset, Region
from casa_assets.model.asset.parts import Box, Link, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

Bounds = tuple[Floats, Floats]
# A surface this near to a wall is the wall; share of its cavity that a shelf covers; least height of a region.
WALL_DISTANCE_M, MIN_SHELF_COVERAGE, MIN_REGION_M = 0.03, 0.5, 0.06
# Cells of a plan each way, greatest thickness of a shelf, and samples of a surface.
PLAN_CELLS, MAX_SHELF_THICKNESS_M, SAMPLES = 12, 0.02, 40000
# Coordinates that differ by less are one, and the distance of regions from boards.
SAME_PLACE_M, BOARD_DISTANCE_M = 0.002, 0.002
# Greatest height of a region over a rack, and the distance to what is above it.
MAX_HEIGHT_OVER_RACK_M, CLEARANCE_M = 0.14, 0.01
# Drawers and racks that take this share of a region make it theirs.
MAX_OCCUPIED_SHARE = 0.4
# Share of the sides of a drawer that its walls and front take.
DRAWER_INSET = 0.12
PIXELS = 192
# Height that a cup needs, and depth of its niche as a share of the machine.
MIN_CUP_HEIGHT_M, MIN_NICHE_DEPTH_SHARE = 0.055, 0.15
# Depth of a slot as a share of the height, its width, and its length to width.
MIN_SLOT_DEPTH_SHARE, SLOT_WIDTH_M, MIN_SLOT_RATIO = 0.2, (0.015, 0.06), 2.0
# Diameters of burners and rings, metres: from the cap of a simmer burner to the ring of a large zone.
MIN_DIAMETER_M, MAX_DIAMETER_M = 0.035, 0.34
# The smallest burner is at least this share of the largest.
MIN_SIZE_OF_LARGEST = 0.3
# Burners lie within this of the median level of the discs; higher ones are guards at the back.
MAX_LEVEL_DIFFERENCE_M = 0.09
# Outline of a disc: how much its sides differ (as those of a hexagon), and its area from that of its ellipse.
MAX_SIDE_DIFFERENCE, ROUNDNESS_TOLERANCE = 0.16, 0.09
# A burner within this share of the span from the middle of rows or columns is in the middle one.
MIDDLE_SHARE = 0.2
PLACES = frozenset(
    {"rear_left", "rear_center", "rear_right", "front_left", "front_center", "front_right", "center", "left", "right"}
)


def link_bounds(asset: Asset, link: str, held: bool = True) -> Bounds:
    """Return the lower and upper corner of a link's visuals, asset frame, metres; `held`: with its handle."""
    pose = asset.asset_from_link(link)
    clouds = [pose.apply(v.mesh.vertices) for v in asset.link(link).visuals if held or v.label != "handle"]
    points = np.concatenate(clouds or [np.array([pose.position])])
    return points.min(axis=0), points.max(axis=0)


def region_bounds(asset: Asset, region: Region) -> Bounds:
    """Return the lower and upper corner of an upright region, asset frame, metres."""
    middle = asset.asset_from_link(region.link).apply(np.array([region.pose.position]))[0]
    half = np.array(region.size) / 2
    return middle - half, middle + half


def closing_link(asset: Asset, region: Region) -> str:
    """Return the name of the link that closes a region: the smallest front before its middle; empty for none."""
    lower, upper = region_bounds(asset, region)
    middle = (lower + upper) / 2
    found = []
    for joint in asset.joints:
        a, b = link_bounds(asset, joint.child)
        before = a[1] < lower[1] + 0.02
        if before and a[0] <= middle[0] <= b[0] and a[2] <= middle[2] <= b[2] and joint.behind is None:
            found.append((round(float((b - a)[0] * (b - a)[2]), 6), joint.child))
    return min(found)[1] if found else ""


def split_by_shelves(asset: Asset, region: Region) -> list[Region]:
    """Split a region of the body into the levels between its shelves, lowest first; one without shelves stays whole.

    Upright boards split it first. Each level reaches from the collider of its floor to that of the shelf above.
    """
    if region.link != "object" or region.kind != "box":
        return [region]
    lower, upper = region_bounds(asset, region)
    if (upper - lower).min() < MIN_REGION_M or _filled(asset, (lower + upper) / 2):
        lower, upper = _before(asset, lower, upper)
    boards = _boards(asset, lower, upper, 0)
    lefts = [float(lower[0]), *(far + BOARD_DISTANCE_M for _, far in boards)]
    rights = [*(near - BOARD_DISTANCE_M for near, _ in boards), float(upper[0])]
    out = []
    for left, right in zip(lefts, rights, strict=True):
        a, b = lower.copy(), upper.copy()
        a[0], b[0] = left, right
        if right - left >= MIN_REGION_M:
            out += _levels(asset, region, a, b)
    return out or [region]


def _before(asset: Asset, lower: Floats, upper: Floats) -> Bounds:
    """Return the space behind the fronts before a place, up to the walls, for regions that boards divide."""
    middle = (lower + upper) / 2
    fronts = [
        link_bounds(asset, j.child) for j in asset.joints if link_label(asset, j.child) == "door" and j.behind is None
    ]
    fronts = [(a, b) for a, b in fronts if a[2] <= middle[2] <= b[2] and b[1] <= middle[1]]
    near = [(a, b) for a, b in fronts if a[0] - WALL_DISTANCE_M <= middle[0] <= b[0] + WALL_DISTANCE_M]
    if not near:
        return lower, upper
    a, b = np.min([f[0] for f in near], axis=0), np.max([f[1] for f in near], axis=0)
    whole = link_bounds(asset, "object")
    a, b = np.maximum(a, whole[0]), np.minimum(b, whole[1])
    a[1], b[1] = lower[1], upper[1]
    return a + BOARD_DISTANCE_M, b - BOARD_DISTANCE_M


def _levels(asset: Asset, region: Region, lower: Floats, upper: Floats) -> list[Region]:
    """Return the levels between shelves of the space between two corners."""
    x, y = round_mm(float(lower[0] + upper[0]) / 2), round_mm(float(lower[1] + upper[1]) / 2)
    spans = _column(asset, asset.root, x, y)
    out = []
    boards = _boards(asset, lower, upper, 2)
    floors = [float(lower[2]), *(far for _, far in boards)]
    for floor, roof in zip(floors, [*(near for near, _ in boards), float(upper[2])], strict=True):
        middle = (floor + roof) / 2
        under = [t for _, t, _ in spans if floor - WALL_DISTANCE_M <= t <= middle]
        floor = max(under, default=floor)
        roof = min([roof, *(b for b, _, _ in spans if b >= middle)]) - BOARD_DISTANCE_M
        if roof - floor >= MIN_REGION_M and not _filled(asset, np.array([x, y, (floor + roof) / 2])):
            left, right = _between(asset, np.array([x, y, (floor + roof) / 2]), float(lower[0]), float(upper[0]))
            if min(right - left, float(upper[1] - lower[1])) < MIN_REGION_M:
                continue
            pose = Pose(position=round_mm_vec3(((left + right) / 2, y, (floor + roof) / 2)))
            size = round_mm_vec3((right - left, upper[1] - lower[1], roof - floor))
            out.append(region.replace(pose=pose, size=size))
    return out


def _filled(asset: Asset, point: Floats) -> bool:
    return any(b < point[2] < t for b, t, _ in _column(asset, asset.root, float(point[0]), float(point[1])))


def _between(asset: Asset, point: Floats, lower: float, upper: float) -> tuple[float, float]:
    """Return how far it is free to the left and right of a point, between two ends; asset frame."""
    turned = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    y, z = float(point[1]), float(point[2])
    for collider in asset.root.colliders:
        span = _upright(tessellate(collider.shape, collider.pose)[0] @ turned.T, -z, y)
        if span is not None and span[1] <= point[0]:
            lower = max(lower, span[1] + BOARD_DISTANCE_M)
        elif span is not None and span[0] >= point[0]:
            upper = min(upper, span[0] - BOARD_DISTANCE_M)
    return lower, upper


def region_below_racks(asset: Asset, region: Region) -> Region | None:
    """Return a region up to the lowest rack that slides in it; None if too little of it is left."""
    if region.link != "object":
        return region
    lower, upper = region_bounds(asset, region)
    racks = [link_bounds(asset, k.name) for k in asset.links if k.name.startswith("rack")]
    within = [a for a, b in racks if (a < upper).all() and (b > lower).all()]
    if not within:
        return region
    roof = min(float(a[2]) for a in within) - CLEARANCE_M
    if roof - lower[2] < MIN_REGION_M:
        return None
    x, y, _ = region.pose.position
    size = (region.size[0], region.size[1], round_mm(roof - float(lower[2])))
    return region.replace(pose=Pose(position=(x, y, round_mm((roof + float(lower[2])) / 2))), size=size)


def region_within_colliders(asset: Asset, region: Region) -> Region:
    """Return a region of the body that reaches from what lies on its floor to the roof, as the colliders have them.

    On the floor lies the turntable of a microwave, for instance; a roof may be thicker to collide with than it looks.
    """
    if region.link != "object":
        return region
    lower, upper = region_bounds(asset, region)
    x, y, _ = region.pose.position
    spans = _column(asset, asset.root, x, y)
    floor = max((t for _, t, _ in spans if lower[2] + SAME_PLACE_M < t <= lower[2] + WALL_DISTANCE_M), default=lower[2])
    roof = min((b for b, _, _ in spans if upper[2] - WALL_DISTANCE_M <= b < upper[2] - SAME_PLACE_M), default=upper[2])
    height = round_mm(float(roof - floor))
    if height < MIN_REGION_M or (floor == lower[2] and roof == upper[2]):
        return region
    return region.replace(pose=Pose(position=(x, y, round_mm((floor + roof) / 2))), size=(*region.size[:2], height))


def is_occupied(asset: Asset, region: Region) -> bool:
    """Return whether drawers or racks take up a region of the body, which then belongs to them."""
    lower, upper = region_bounds(asset, region)
    boxes = [link_bounds(asset, j.child) for j in asset.joints if j.behind is not None]
    inside = [np.minimum(b[1], upper) - np.maximum(b[0], lower) for b in boxes]
    share = sum(float(np.prod(np.maximum(i, 0.0))) for i in inside) / float(np.prod(upper - lower))
    return region.link == "object" and share >= MAX_OCCUPIED_SHARE


def region_over_rack(asset: Asset, rack: str, regions: list[Region]) -> Region | None:
    """Return the region over a rack, which moves with it: from its floor up to what is above."""
    link = asset.link(rack)
    lower, upper = link_bounds(asset, rack)
    middle = (lower + upper) / 2
    spans = _column(asset, link, float(middle[0]), float(middle[1]))
    if not spans:
        return None
    floor = spans[0][1]
    boxes = [region_bounds(asset, r) for r in regions]
    over = [(a <= middle)[:2].all() and (middle <= b).all() for a, b in boxes]
    above = [float(b[2]) for (_, b), is_over in zip(boxes, over, strict=True) if is_over]
    for other in asset.links:
        if other.name != rack and other.name.startswith("rack"):
            a, b = link_bounds(asset, other.name)
            if a[2] > middle[2] and a[0] < middle[0] < b[0]:
                above.append(float(a[2]))
    roof = min([floor + MAX_HEIGHT_OVER_RACK_M, *(z - CLEARANCE_M for z in above)])
    inset = 0.08 * (upper - lower)[:2]
    a, b = lower[:2] + inset, upper[:2] - inset
    return _region(asset, rack, np.append(a, floor), np.append(b, roof))


def region_in_drawer(asset: Asset, drawer: str) -> Region | None:
    """Return the region in a drawer's box, which moves with it; None if the box has no floor, or is full."""
    link = asset.link(drawer)
    lower, upper = link_bounds(asset, drawer, held=False)
    inset = DRAWER_INSET * (upper - lower)[:2]
    a, b = lower[:2] + inset, upper[:2] - inset
    middle = (a + b) / 2
    spans = _column(asset, link, float(middle[0]), float(middle[1]))
    if not spans or spans[0][1] > lower[2] + 0.4 * (upper[2] - lower[2]):
        return None
    floor, roof = spans[0][1], min([float(upper[2]) - CLEARANCE_M, *(s[0] for s in spans[1:])])
    return _region(asset, drawer, np.append(a, floor), np.append(b, roof))


def _region(asset: Asset, link: str, lower: Floats, upper: Floats) -> Region | None:
    """Return the region of a link, and with its name, between two corners, asset frame; None if it is too small."""
    wide, deep, high = (upper - lower).tolist()
    if high < 0.03 or min(wide, deep) < MIN_REGION_M:
        return None
    local = asset.asset_from_link(link).inverse().apply((lower + upper)[None] / 2)[0]
    return Region(name=link, link=link, pose=Pose(position=round_mm_vec3(local)), size=round_mm_vec3(upper - lower))


def floor_collider(asset: Asset, region: Region) -> str | None:
    """Return the name of the body's collider that is the floor of a region; None if nothing is under its middle."""
    lower, upper = region_bounds(asset, region)
    middle = (lower + upper) / 2
    spans = _column(asset, asset.root, float(middle[0]), float(middle[1]))
    under = [(round(abs(t - float(lower[2])), 6), name) for _, t, name in spans if abs(t - lower[2]) <= WALL_DISTANCE_M]
    return min(under)[1] if under else None


def _boards(asset: Asset, lower: Floats, upper: Floats, axis: int) -> list[tuple[float, float]]:
    """Return both faces of each board across an axis within a box, ascending; boards, glass and wires count."""
    clouds = [surface_samples(v.mesh.vertices, v.mesh.faces.astype(np.int64), SAMPLES) for v in asset.root.visuals]
    points = np.concatenate(clouds)
    inset = np.full(3, WALL_DISTANCE_M)
    inset[axis] = MIN_REGION_M
    points = points[((points > lower + inset) & (points < upper - inset)).all(axis=1)]
    if not len(points):
        return []
    others = [k for k in range(3) if k != axis]
    cell = np.floor((points[:, others] - lower[others]) / (upper - lower)[others] * PLAN_CELLS).astype(np.int64)
    slab = np.floor((points[:, axis] - lower[axis]) / MAX_SHELF_THICKNESS_M).astype(np.int64)
    filled = np.zeros((int(slab.max()) + 2, PLAN_CELLS, PLAN_CELLS), dtype=bool)
    filled[slab, cell[:, 0], cell[:, 1]] = True
    # A board may lie across the border of two slabs.
    both = (filled[:-1] | filled[1:]).mean(axis=(1, 2))
    found: list[tuple[float, float]] = []
    for i in np.flatnonzero(both >= MIN_SHELF_COVERAGE).tolist():
        faces = _faces(points[(slab >= i) & (slab <= i + 1), axis])
        if found and faces[0] - found[-1][1] < MIN_REGION_M:
            found[-1] = (min(found[-1][0], faces[0]), max(found[-1][1], faces[1]))
        else:
            found.append(faces)
    return found


def _faces(at: Floats) -> tuple[float, float]:
    """Return the first and last coordinate where many points are; what else crosses a board has fewer."""
    lower = float(at.min())
    count = np.bincount(np.floor((at - lower) / SAME_PLACE_M).astype(np.int64))
    many = np.flatnonzero(count >= 0.25 * count.max())
    return lower + float(many[0]) * SAME_PLACE_M, lower + float(many[-1] + 1) * SAME_PLACE_M


def _column(asset: Asset, link: Link, x: float, y: float) -> list[tuple[float, float, str]]:
    """Return where a vertical line passes through colliders of a link: bottom, top, name; asset frame."""
    pose = asset.asset_from_link(link.name)
    out = []
    for collider in link.colliders:
        span = _upright(tessellate(collider.shape, pose @ collider.pose)[0], x, y)
        if span is not None:
            out.append((*span, collider.name))
    return sorted(out)


def _upright(points: Floats, x: float, y: float) -> tuple[float, float] | None:
    """Return the bottom and top of a convex hull on a vertical line, or None if the line misses it."""
    lower, upper = points.min(axis=0), points.max(axis=0)
    if not (lower[0] <= x <= upper[0] and lower[1] <= y <= upper[1]):
        return None
    try:
        planes = ConvexHull(points).equations
    except QhullError:
        return float(lower[2]), float(upper[2])
    off = -(planes[:, 0] * x + planes[:, 1] * y + planes[:, 3])
    up, down, level = planes[:, 2] > 1e-9, planes[:, 2] < -1e-9, np.abs(planes[:, 2]) <= 1e-9
    if (off[level] < -1e-9).any():
        return None
    top = float((off[up] / planes[up, 2]).min(initial=float(upper[2])))
    bottom = float((off[down] / planes[down, 2]).max(initial=float(lower[2])))
    return (bottom, top) if bottom < top else None


def link_label(asset: Asset, link: str) -> str:
    """Return the label of a link's visuals besides its handle."""
    labels = [v.label for v in asset.link(link).visuals if v.label and v.label != "handle"]
    return labels[0] if labels else ""


def find_cup_niche(asset: Asset) -> Bounds | None:
    """Return the niche under the spout of a coffee machine, open to its front, or None; a cup goes on its floor.

    A machine without a drip tray pours onto the surface that it is placed on.
    """
    points, faces, _ = joined_meshes([v.mesh for v in asset.root.visuals])
    image = render_depth(points, np.concatenate(faces), SIDES[FRONT], PIXELS)
    deep = float(np.ptp(points[:, 1]))
    back = np.where(np.isfinite(image.depth), image.depth, deep)
    inner = back >= MIN_NICHE_DEPTH_SHARE * deep
    # What is open above is no place under something.
    under = inner & np.maximum.accumulate(~inner, axis=0)
    floored = under & np.flip(np.maximum.accumulate(np.flip(~inner, 0), axis=0), 0)
    best = _largest(floored, image) or _largest(under, image)
    return None if best is None else _box(image, points, back, best)


def _largest(places: Mask, image: DepthImage) -> tuple[int, int, int, int] | None:
    """Return the rows and columns of the largest region that a cup fits into."""
    best: tuple[float, int, int, int, int] | None = None
    label, _ = ndimage.label(places)
    for number, place in enumerate(ndimage.find_objects(label), start=1):
        mask = label[place] == number
        a, b = place[0].start, place[0].stop
        c, d = place[1].start, place[1].stop
        tall, wide = (b - a) * image.pixel, (d - c) * image.pixel
        if tall < MIN_CUP_HEIGHT_M or wide < MIN_CUP_HEIGHT_M or mask.mean() < 0.6:
            continue
        size = float(mask.sum())
        if best is None or size > best[0]:
            best = (size, a, b, c, d)
    return None if best is None else best[1:]


def find_toaster_slots(asset: Asset) -> list[Bounds]:
    """Return long narrow niches that are open above, sorted from the left, or from the front where they lie across."""
    points, faces, _ = joined_meshes([v.mesh for v in asset.root.visuals])
    image = render_depth(points, np.concatenate(faces), SIDES[TOP], PIXELS)
    lower, upper = points.min(axis=0), points.max(axis=0)
    tall = float(upper[2] - lower[2])
    deep = np.isfinite(image.depth) & (image.depth >= MIN_SLOT_DEPTH_SHARE * tall)
    label, _ = ndimage.label(deep)
    out = []
    for number, place in enumerate(ndimage.find_objects(label), start=1):
        mask = label[place] == number
        a, b = place[0].start, place[0].stop
        c, d = place[1].start, place[1].stop
        sides = sorted(((b - a) * image.pixel, (d - c) * image.pixel))
        edge = c == 0 or a == 0 or d == deep.shape[1] or b == deep.shape[0]
        if (
            edge
            or not SLOT_WIDTH_M[0] <= sides[0] <= SLOT_WIDTH_M[1]
            or sides[1] < MIN_SLOT_RATIO * sides[0]
            or mask.mean() < 0.8
        ):
            continue
        floor = float(upper[2]) - float(np.median(image.depth[place][mask]))
        # Row 0 is the far side.
        y1, y0 = (float(image.lower[1]) + (deep.shape[0] - r) * image.pixel for r in (a, b))
        x0, x1 = (float(image.lower[0]) + k * image.pixel for k in (c, d))
        px = image.pixel
        out.append(_niche((x0 + px, y0 + px, floor), (x1 - px, y1 - px, upper[2])))
    right, back = (out[0][1] - out[0][0])[:2] if out else (1.0, 0.0)
    return sorted(out, key=lambda niche: float(niche[0][0 if back >= right else 1]))


def niche_floor(niche: Bounds, thick: float = 0.003) -> tuple[Box, Pose]:
    """Return a thin board whose top is the floor of a niche."""
    lower, upper = niche
    x, y, _ = (float(v) for v in upper - lower)
    at = (lower + upper) / 2
    pose = Pose(position=round_mm_vec3((at[0], at[1], lower[2] - thick / 2)))
    return Box(size=(round_mm(x), round_mm(y), thick)), pose


def _box(image: DepthImage, points: Floats, back: Floats, span: tuple[int, int, int, int]) -> Bounds:
    a, b, c, d = span
    rows = back.shape[0]
    front = float(points[:, 1].min())
    x0, x1 = (float(image.lower[0]) + k * image.pixel for k in (c, d))
    z1, z0 = (float(image.lower[1]) + (rows - r) * image.pixel for r in (a, b))
    far = front + float(np.median(back[a:b, c:d]))
    # It begins where what stands under it does.
    near = front + float(np.median(back[b + 1, c:d])) if b + 1 < rows else front
    return _niche((x0, min(near, far - 0.02), z0), (x1, far, z1))


def _niche(lower: Vec3, upper: Vec3) -> Bounds:
    return np.array(round_mm_vec3(lower)), np.array(round_mm_vec3(upper))


@dataclass(frozen=True)
class Burner:
    """A burner: its place, the middle of its top and its radius; metres, asset frame."""

    loc: str
    middle: tuple[float, float, float]
    radius: float


def find_burners(asset: Asset) -> tuple[Burner, ...]:
    """Return the burners on the top of the body; empty if fewer than two are found or their places are ambiguous."""
    found: list[tuple[float, float, float, float]] = []
    discs = [d for v in asset.root.visuals for d in _discs(v.mesh)]
    for disc in sorted(discs, key=lambda d: (-round(d[3], 5), d[0], d[1])):
        # Of discs that lie above each other the widest, so that none is within another.
        if all(np.hypot(disc[0] - o[0], disc[1] - o[1]) > 0.8 * (o[3] + 0.5 * disc[3]) for o in found):
            found.append(disc)
    if not found:
        return ()
    top = float(np.median([z for _, _, z, _ in found]))
    found = [f for f in found if abs(f[2] - top) <= MAX_LEVEL_DIFFERENCE_M]
    if not found:
        return ()
    widest = max(r for _, _, _, r in found)
    found = sorted(f for f in found if f[3] >= MIN_SIZE_OF_LARGEST * widest)
    points = np.concatenate([v.mesh.vertices for v in asset.root.visuals])
    burners = []
    columns, rows = _thirds([f[0] for f in found]), _thirds([f[1] for f in found])
    for (x, y, z, r), column, row in zip(found, columns, rows, strict=True):
        words = [w for w in (("front", "", "rear")[row], ("left", "center", "right")[column]) if w]
        near = np.linalg.norm(points[:, :2] - (x, y), axis=1) <= 0.9 * r
        upper = points[near & (points[:, 2] <= top + MAX_LEVEL_DIFFERENCE_M), 2]
        level = float(upper.max()) if len(upper) else z  # of a mere ring the rim
        burners.append(Burner("_".join(words), round_mm_vec3((x, y, level)), round_mm(r)))
    names = [b.loc for b in burners]
    if len(burners) < 2 or len(set(names)) < len(names) or not set(names) <= PLACES:
        return ()
    return tuple(burners)


def burner_faces(mesh: Mesh, burner: Burner, below: float = 0.03) -> Mask:
    """Mark the (F,) faces of a mesh of the body that belong to a burner: those within its circle near its top."""
    corners = mesh.vertices[mesh.faces]
    away = np.linalg.norm(corners[..., :2] - np.array(burner.middle[:2]), axis=2)
    near = (away <= 1.06 * burner.radius).all(axis=1)
    return np.asarray(near & (np.abs(corners[..., 2] - burner.middle[2]) <= below).all(axis=1))


def _discs(mesh: Mesh) -> list[tuple[float, float, float, float]]:
    """Return the middle, top and radius of connected pieces of a mesh whose outline from above is a circle."""
    vertices = np.asarray(mesh.vertices)
    grid = np.round(vertices / 1e-5).astype(np.int64)
    _, same = np.unique(grid, axis=0, return_inverse=True)
    same = same.reshape(-1)
    faces = same[np.asarray(mesh.faces, dtype=np.int64)]
    count = int(same.max()) + 1
    ends = np.concatenate([faces[:, :2], faces[:, 1:]])
    of = connected_groups(count, *ends.T)[same]
    order = np.argsort(of, kind="stable")
    pieces = np.split(order, np.cumsum(np.bincount(of))[:-1])
    out = []
    for piece in pieces:
        points = vertices[piece]
        if len(points) < 8:
            continue
        lower, upper = points.min(axis=0), points.max(axis=0)
        wide = (upper - lower)[:2]
        if (
            not MIN_DIAMETER_M <= wide.max() <= MAX_DIAMETER_M
            or wide.max() - wide.min() > MAX_SIDE_DIFFERENCE * wide.max()
            or upper[2] - lower[2] > 0.6 * wide.max()
        ):
            continue
        # The outline of a circle, or of a polygon with six corners or more.
        if abs(outline_area(points[:, :2]) / (np.pi / 4 * float(np.prod(wide))) - 1.0) > ROUNDNESS_TOLERANCE:
            continue
        middle = (lower + upper) / 2
        out.append((float(middle[0]), float(middle[1]), float(upper[2]), float(wide.max()) / 2))
    return out


def _thirds(values: Sequence[float]) -> list[int]:
    """Sort values into 0, 1 or 2: low, middle, high; all in the middle where they do not differ."""
    lower, upper = min(values), max(values)
    if upper - lower < MIN_DIAMETER_M:
        return [1] * len(values)
    share = [(v - lower) / (upper - lower) - 0.5 for v in values]
    return [1 if abs(s) < MIDDLE_SHARE else 0 if s < 0 else 2 for s in share]
