"""Checks of objects out of numbers: sides and print of each member of a category, and all members together."""

from __future__ import annotations

import io
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from PIL import Image
from scipy import ndimage

from casa_assets.checks.check import Check, Measurement, all_at_least, at_most, least, not_applicable, worst_above
from casa_assets.checks.library import SAME_COLORS, SAME_SIZE
from casa_assets.core.numeric import Floats, Ints, Mask, linear_from_srgb_array
from casa_assets.mesh.registration import descriptor_distances
from casa_assets.model.asset.asset import Asset, Signature
from casa_assets.model.asset.material import Material, PrintedLine
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Severity
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category

SIDES = ("shortest", "middle", "longest")
# A pixel belongs to a letter where it is covered by this share of what the best one is; strokes may be thinner than a
# pixel. What is near such a pixel is the ground that the letter is read on.
LETTER, LEAST_COVER, GROUND_PX = 0.5, 0.2, 2
# Places of a line that are looked up on the surface; letters are as high as three quarters of their columns at most.
LINE_PLACES, HEIGHT_SHARE = 240, 75.0
# Share of the way from black to white that is scattered by the eye. Ref: WCAG 2.1, contrast ratio.
FLARE = 0.05
NO_PRINT = "nothing is printed on it"
# The camera that reads: a common one on a wrist, 640 pixels wide with 60 degrees, 20 cm before the middle of the line.
DISTANCE_M, WIDE_PX, FIELD_DEG = 0.2, 640, 60.0
FOCAL_PX = WIDE_PX / 2 / math.tan(math.radians(FIELD_DEG) / 2)
# A letter that is turned away by more than this, 75 degrees, is less than a quarter as wide as on the label and not
# read; of a line, UNSEEN_SHARE may be. Both are choices: on a round bottle a long name always ends near the edge.
SEEN_COS, UNSEEN_SHARE = 0.25, 0.2
# A line is as high as the lowest of what is seen of it; one place in twenty may lie on a crease of the paper.
LOW_PERCENT = 5
SAME_SHAPE = 0.02  # descriptors of one shape under two triangulations are this far apart at most
MIN_MEMBERS = 12  # with fewer members the nearest one of the same kind is too often not there
# Share of the mean variance within categories that is added along each axis, so that no axis counts without bounds.
SHRINKAGE = 0.3
# Rows of the table of distances that are made at a time.
BLOCK = 512
TOO_FEW = f"there are no two categories of at least {MIN_MEMBERS} members"
# Categories that a message names.
NAMED = 4
ERROR, WARNING = Severity.ERROR, Severity.WARNING


@dataclass(frozen=True, eq=False)
class ObjectMember:
    """A member of a category, compared by identity; `printed`: material -> lines that say what is in the package."""

    asset: Asset
    category: Category
    printed: Mapping[str, tuple[PrintedLine, ...]]


def sides_fit_category(member: ObjectMember, limit: float) -> Measurement:
    """OBJ001: factor between a side and the nearer end of its usual range, the worst of three sides; below 1 inside it.

    Sides are matched in order of length, since many things rest in more than one way. Of a portion only the longest is
    known.
    """
    category, portion = member.category, member.asset.labels.portion
    sides = np.sort(np.ptp(member.asset.bounds, axis=0))
    if portion in category.portions:
        span = category.usual(portion).longest_m
        message = f"{category.called(portion)} is {100 * span.low:.3g} to {100 * span.high:.3g} cm long"
        return at_most(span.beyond(float(sides[-1])), limit, "bounds", message)
    ranges = category.extents
    lows, highs = (np.sort([getattr(side, end) for side in ranges]) for end in ("low", "high"))
    rows = []
    for name, side, low, high in zip(SIDES, sides.tolist(), lows.tolist(), highs.tolist(), strict=True):
        usual = f"{100 * low:.3g} to {100 * high:.3g} cm are usual for a {category.id}"
        message = f"its {name} side is {100 * side:.3g} cm; {usual}; change the numbers it is of"
        rows.append(("bounds", max(low / side, side / high), message))
    return worst_above(rows, limit, "it has no sides")


@dataclass(frozen=True)
class LineOnSurface:
    """A line of letters as it lies on what is seen: height in the picture, and contrast ratio of WCAG to its ground.

    `points`, `normals`: (N, 3) places of its letters, link frame. `up`: (N, 3) from the foot to the head of a letter
    there, metres. `mirrored`: share of the places where it reads from right to left.
    """

    text: str
    material: str
    height_px: float
    contrast: float
    points: Floats
    normals: Floats
    up: Floats
    mirrored: float


@lru_cache(maxsize=4)
def lines_on_surface(member: ObjectMember) -> tuple[LineOnSurface, ...]:
    """Every printed line of a member that some surface shows. Cached since several checks ask for it."""
    looks = {m.id: m for m in member.asset.materials}
    found = []
    for visual in (visual for link in member.asset.links for visual in link.visuals):
        if visual.material not in member.printed or visual.mesh.uv is None:
            continue
        picture = _luminance(looks[visual.material])
        found += [_on_mesh(line, visual.material, picture, visual.mesh) for line in member.printed[visual.material]]
    return tuple(line for line in found if line is not None)


def _luminance(look: Material) -> Floats:
    """(H, W) relative luminance of a picture as it is shown. Ref: ITU-R BT.709."""
    assert look.base_color_texture is not None
    with Image.open(io.BytesIO(look.base_color_texture.png)) as opened:
        shown = np.asarray(opened.convert("RGB")) / 255.0
    light: Floats = (linear_from_srgb_array(shown) * np.array(look.base_color[:3])) @ np.array([0.2126, 0.7152, 0.0722])
    return light


def _on_mesh(line: PrintedLine, material: str, picture: Floats, mesh: Mesh) -> LineOnSurface | None:
    """The line on one mesh, on the side where it is most readable; None if the mesh does not show it."""
    letters = line.cover >= LETTER * max(float(line.cover.max()), LEAST_COVER)
    if not letters.any():
        return None
    rows, columns = np.nonzero(letters)
    chosen = np.linspace(0, len(rows) - 1, min(len(rows), LINE_PLACES)).astype(np.int64)
    high, wide = line.cover.shape
    at = np.stack([(columns[chosen] + 0.5) / wide, 1 - (rows[chosen] + 0.5) / high], axis=1)
    # Extent of a column from its top to its foot, without what a line that is bent adds.
    columnwise = letters.T if line.runs_upwards else letters
    top, foot = columnwise.argmax(axis=0), columnwise.shape[0] - columnwise[::-1].argmax(axis=0)
    height = float(np.percentile((foot - top)[columnwise.any(axis=0)], HEIGHT_SHARE))
    contrast = _contrast(picture, letters)
    copies = []
    for face, weights in _copies(at, mesh):
        corners = mesh.vertices[mesh.faces[face]]
        along_u, along_v, turned = _directions(mesh, face)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        # In a line that runs upwards the head of a letter is to its left.
        up = -along_u * height / wide if line.runs_upwards else along_v * height / high
        points, looks = np.einsum("nk,nkd->nd", weights, corners), normal / np.linalg.norm(normal, axis=1)[:, None]
        mirrored = float(np.mean(turned < 0))
        copies.append(LineOnSurface(line.text, material, height, contrast, points, looks, up, mirrored))

    def readable(one: LineOnSurface) -> tuple[bool, float]:
        # What is not mirrored, has more of its letters, and larger ones.
        return one.mirrored <= 0.5, len(one.points) * float(np.median(np.linalg.norm(one.up, axis=1)))

    return max(copies, key=readable, default=None)


def _contrast(picture: Floats, letters: Mask) -> float:
    """Contrast ratio of the letters to the ground around them, 1..21."""
    near = ndimage.binary_dilation(letters, iterations=GROUND_PX) & ~ndimage.binary_dilation(letters)
    if not near.any():
        return 1.0
    one, other = float(np.median(picture[letters])), float(np.median(picture[near]))
    return (max(one, other) + FLARE) / (min(one, other) + FLARE)


def _copies(at: Floats, mesh: Mesh) -> Iterator[tuple[Ints, Floats]]:
    """Sides of a mesh that show the same (N, 2) places of a picture, such as the front and the back of a bag.

    Yields (M,) faces that show M of the places and look to one side, and (M, 3) weights of their corners.
    """
    candidates, second, third, inside = _hits(at, mesh)
    if not inside.any():
        return
    corners = mesh.vertices[mesh.faces[candidates]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
    place = np.flatnonzero(inside.any(axis=1))
    middle = int(np.linalg.norm(at[place] - at.mean(axis=0), axis=1).argmin())
    # The sides are those on which the place in the middle is shown.
    for start in np.flatnonzero(inside[place[middle]]):
        best = np.where(inside[place], normal @ normal[start], -np.inf).argmax(axis=1)
        same = (normal[best] @ normal[start]) > -0.5
        if same.any():
            one, two = second[place, best][same], third[place, best][same]
            yield candidates[best[same]], np.stack([1 - one - two, one, two], axis=1)


def _hits(at: Floats, mesh: Mesh) -> tuple[Ints, Floats, Floats, Mask]:
    """(F,) faces near N places of the picture; (N, F) barycentric weights of their last corners; who holds whom."""
    assert mesh.uv is not None
    uv = mesh.uv[mesh.faces]
    ab, ac = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    near = (uv.min(axis=1) <= at.max(axis=0)).all(axis=1) & (uv.max(axis=1) >= at.min(axis=0)).all(axis=1)
    candidates = np.flatnonzero(near & (np.abs(area) > 0))
    ab, ac, area = ab[candidates], ac[candidates], area[candidates]
    offset = at[:, None, :] - uv[candidates, 0]
    second = (offset[..., 0] * ac[:, 1] - offset[..., 1] * ac[:, 0]) / area
    third = (ab[:, 0] * offset[..., 1] - ab[:, 1] * offset[..., 0]) / area
    inside = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1 + 1e-9)
    return candidates, second, third, inside


def _directions(mesh: Mesh, face: Ints) -> tuple[Floats, Floats, Floats]:
    """(N, 3) metres along the width and the height of a whole picture on each face; (N,) sign: negative if mirrored."""
    assert mesh.uv is not None
    uv, corners = mesh.uv[mesh.faces[face]], mesh.vertices[mesh.faces[face]]
    ab, ac = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    along_u = (one * ac[:, 1, None] - two * ab[:, 1, None]) / area[:, None]
    along_v = (two * ab[:, 0, None] - one * ac[:, 0, None]) / area[:, None]
    return along_u, along_v, np.sign(area)


def letters_are_large(member: ObjectMember, limit: float) -> Measurement:
    """OBJ002: height of the letters in the picture of a camera at 20 cm, pixels; the least of the printed lines."""
    heights, problems = [], []
    for line in lines_on_surface(member):
        height, unseen = seen_from(line)
        heights.append(height)
        where = f"materials/{line.material}"
        if line.mirrored > 0.5:
            problems.append((where, f"shows {line.text!r} mirrored; turn its texture coordinates"))
        elif unseen > UNSEEN_SHARE:
            message = f"bends {unseen:.0%} of {line.text!r} out of sight; make the front of the label narrower"
            problems.append((where, message))
        elif height < limit:
            problems.append((where, f"{line.text!r} is {height:.1f} pixels high at 20 cm; make its letters larger"))
    return least(heights, problems, NO_PRINT)


def letters_are_resolved(member: ObjectMember, limit: float) -> Measurement:
    """OBJ003: height of the letters in the picture that is laid on, pixels; the least of the printed lines."""
    heights = {f"materials/{line.material}": line.height_px for line in _worst(member, "height_px")}
    return all_at_least(heights, limit, "has letters of {:.0f} pixels; enlarge them, or the picture", NO_PRINT)


def letters_stand_out(member: ObjectMember, limit: float) -> Measurement:
    """OBJ004: contrast ratio of the letters to what is around them, 1..21; the least of the printed lines."""
    contrasts = {f"materials/{line.material}": line.contrast for line in _worst(member, "contrast")}
    return all_at_least(contrasts, limit, "has letters at {:.1f} to 1 from their ground; change a colour", NO_PRINT)


def seen_from(line: LineOnSurface) -> tuple[float, float]:
    """Height of the lowest letters in pixels of the camera; share of the line that is turned out of sight."""
    middle, look = line.points.mean(axis=0), line.normals.mean(axis=0)
    camera = middle + DISTANCE_M * look / max(float(np.linalg.norm(look)), 1e-9)
    rays = line.points - camera
    distance = np.linalg.norm(rays, axis=1)
    rays /= distance[:, None]
    across = line.up - np.sum(line.up * rays, axis=1)[:, None] * rays
    heights = FOCAL_PX * np.linalg.norm(across, axis=1) / distance
    seen = -np.sum(line.normals * rays, axis=1) >= SEEN_COS
    return float(np.percentile(heights[seen], LOW_PERCENT)) if seen.any() else 0.0, 1.0 - float(seen.mean())


def _worst(member: ObjectMember, field: str) -> list[LineOnSurface]:
    """The line of each material whose number is the lowest, the lowest last."""
    return sorted(lines_on_surface(member), key=lambda line: -float(getattr(line, field)))


@dataclass(frozen=True)
class CollectedMember:
    """A member by id and category, with the features that identify it: signature, and sides of its box in metres."""

    id: str
    category: str
    signature: Signature
    sides: Vec3


@dataclass(frozen=True)
class CategoryConfusion:
    """How many members of a category are nearer to their own kind, and to others, the most frequent first."""

    category: str
    count: int
    right: int
    others: tuple[tuple[str, int], ...]


@dataclass(frozen=True, eq=False)
class ObjectCollection:
    """Members of categories in the order of the library; compared by identity.

    `look_alikes`: category -> name shared by those that look like one kind; others are separate kinds.
    """

    members: tuple[CollectedMember, ...]
    look_alikes: Mapping[str, str]

    @cached_property
    def nearest_alike(self) -> tuple[tuple[str, str, float], ...]:
        """Of each member the most alike earlier one of its category: its own id, that of the other, their distance.

        Of shape, sides and colours the one that differs most counts, over what copies of one thing may differ by.
        """
        from scipy.spatial.distance import cdist  # here, since SciPy loads slowly and many runs have no members

        found = []
        for category in sorted({member.category for member in self.members}):
            group = [member for member in self.members if member.category == category]
            shapes = [member.signature.shape for member in group]
            sides = np.log([member.sides for member in group])
            tones = np.array([member.signature.color.tones for member in group])
            far = descriptor_distances(shapes, shapes) / SAME_SHAPE
            far = np.maximum(far, cdist(sides, sides, "chebyshev") / SAME_SIZE)
            far = np.maximum(far, cdist(tones, tones, "cityblock") / tones.shape[1] / SAME_COLORS)
            for row in range(1, len(group)):
                nearest = int(far[row, :row].argmin())
                found.append((group[row].id, group[nearest].id, float(far[row, nearest])))
        return tuple(found)

    @cached_property
    def confusions(self) -> tuple[CategoryConfusion, ...]:
        """Of each category with enough members, how many have their nearest neighbour in their own kind."""
        counts = Counter(member.category for member in self.members)
        members = [member for member in self.members if counts[member.category] >= MIN_MEMBERS]
        categories = [member.category for member in members]
        if len(set(categories)) < 2:
            return ()
        taken_for: dict[str, Counter[str]] = {category: Counter() for category in sorted(set(categories))}
        for own, other in zip(categories, _nearest(_places(members)), strict=True):
            taken_for[own][categories[other]] += 1
        kind = {category: self.look_alikes.get(category, category) for category in taken_for}
        rows = []
        for category, found in taken_for.items():
            wrong = {name: count for name, count in found.items() if kind[name] != kind[category]}
            others = tuple(sorted(wrong.items(), key=lambda pair: (-pair[1], pair[0])))
            rows.append(CategoryConfusion(category, counts[category], counts[category] - sum(wrong.values()), others))
        return tuple(rows)


def _places(members: list[CollectedMember]) -> Floats:
    """(N, D) members as points whose distance separates kinds: signatures, scaled by the variation within categories.

    Each group of numbers (shape, sides, colours) is first scaled to the same variance over all members. Then the
    covariance within categories, pooled over all of them, is scaled to unity: features that vary in every category
    count little.

    Ref: Bar-Hillel et al. 2005, relevant component analysis; the shrinkage is ours.
    """
    shapes = [member.signature.shape for member in members]
    groups = (
        np.array([shape.pair_distances for shape in shapes]),
        np.array([shape.center_distances for shape in shapes]),
        np.array([shape.axis_spread for shape in shapes]),
        np.log([member.sides for member in members]),
        np.array([member.signature.color.tones for member in members]),
    )
    scaled = []
    for group in groups:
        centered = group - group.mean(axis=0)
        scaled.append(centered / max(float(np.sqrt((centered**2).sum(axis=1).mean())), 1e-12))
    places = np.concatenate(scaled, axis=1)
    _, kind, count = np.unique([m.category for m in members], return_inverse=True, return_counts=True)
    means = np.zeros((len(count), places.shape[1]))
    np.add.at(means, kind, places)
    within = places - (means / count[:, None])[kind]
    covariance = within.T @ within / max(1, len(members) - len(count))
    spread = max(float(np.trace(covariance)) / len(covariance), 1e-12)
    covariance += SHRINKAGE * spread * np.eye(len(covariance))
    return np.asarray(places @ np.linalg.cholesky(np.linalg.inv(covariance)))


def _nearest(places: Floats) -> Iterator[int]:
    from scipy.spatial.distance import cdist

    for start in range(0, len(places), BLOCK):
        far = cdist(places[start : start + BLOCK], places)
        far[np.arange(len(far)), start + np.arange(len(far))] = np.inf
        yield from far.argmin(axis=1).tolist()


def members_differ(collection: ObjectCollection, limit: float) -> Measurement:
    """OBJ005: distance of the two most alike members of a category, over what copies of one thing may differ by."""
    near = collection.nearest_alike
    like, advice = (row for row in near if row[2] <= limit), "widen what its category draws from"
    problems = [(own, f"is like {other} in shape, sides and colours ({far:.2f}); {advice}") for own, other, far in like]
    return least([distance for _, _, distance in near], problems, "no category has two members")


def members_are_distinct(collection: ObjectCollection, limit: float) -> Measurement:
    """OBJ006: share of all members whose nearest neighbour is of the same kind."""
    rows = collection.confusions
    if not rows:
        return not_applicable(TOO_FEW)
    share = sum(row.right for row in rows) / sum(row.count for row in rows)
    message = f"{share:.1%} of the members are nearest to their own kind; make those of OBJ007 more like themselves"
    return Measurement(share, () if share >= limit else (("library", message),))


def categories_are_distinct(collection: ObjectCollection, limit: float) -> Measurement:
    """OBJ007: the same share of each category, the worst; what it is taken for is named."""
    rows = collection.confusions
    problems = [(row.category, in_words(row)) for row in rows if row.right < limit * row.count]
    return least([row.right / row.count for row in rows], problems, TOO_FEW)


def in_words(row: CategoryConfusion) -> str:
    """The kinds that members of a category are confused with, as a clause for messages."""
    named = ", ".join(f"{name} ({count})" for name, count in row.others[:NAMED])
    wrong = f"{row.count - row.right} of {row.count} are nearer to another kind"
    return f"{wrong}: {named}; tell them apart by form or colour"


# fmt: off
ROWS: tuple[Check, ...] = (
    Check("OBJ001", "Sides of the category", ERROR, ObjectMember, sides_fit_category, "side_slack", "",
          "Each of the three sides is within a factor {limit:g} of the range that is usual for the category; change "
          "the numbers that the member is drawn from, or the range where it is wrong."),
    Check("OBJ002", "Letters at 20 cm", ERROR, ObjectMember, letters_are_large, "letter_seen_px", "px",
          "The brand and the first word on a label are at least {limit:g} pixels high for a camera of 640 pixels and "
          "60 degrees at 20 cm, face it and are not mirrored; enlarge the letters."),
    Check("OBJ003", "Letters in the picture", ERROR, ObjectMember, letters_are_resolved, "letter_px", "px",
          "The brand and the first word are at least {limit:g} pixels high in the picture that is laid on; enlarge the "
          "letters, or shorten the line."),
    Check("OBJ004", "Letters on their ground", ERROR, ObjectMember, letters_stand_out, "letter_contrast", "",
          "The contrast ratio of the brand and the first word to what is around them is at least {limit:g}; change one "
          "of the two colours."),
    Check("OBJ005", "Members differ", WARNING, ObjectCollection, members_differ, "members_apart", "",
          "No two members of a category look like copies: some difference in shape, sides or colours is more than "
          "{limit:g} times that of two copies of one thing; widen the ranges that the category draws from."),
    Check("OBJ006", "Categories can be told apart", WARNING, ObjectCollection, members_are_distinct, "kind_share", "",
          "For at least {limit:.0%} of all members the most similar other member, by shape, sides and colours, is of "
          "their own category or of one that looks the same; change the categories that OBJ007 names."),
    Check("OBJ007", "Each category can be told apart", WARNING, ObjectCollection, categories_are_distinct,
          "kind_share", "", "In each category the most similar other member is of that category for at least "
          "{limit:.0%} of the members; change its form or its colours, or those of the category that it is confused "
          "with."),
)
# fmt: on
