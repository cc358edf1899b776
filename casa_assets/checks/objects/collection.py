"""All members of categories together: which are alike, and categories that are taken for others (OBJ005 to OBJ007)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from casa_assets.checks.check import Measurement, least, not_applicable
from casa_assets.checks.library import SAME_COLORS, SAME_SIZE
from casa_assets.core.numeric import Floats
from casa_assets.mesh.registration import descriptor_distances
from casa_assets.model.asset.provenance import Signature
from casa_assets.model.record import Vec3

# Collection -----------------------------------------------------------------------------------------------------------
# Which are alike, and which are nearer to another kind than to their own.

# Descriptors of one shape under two triangulations are this far apart at most.
SAME_SHAPE = 0.02
# With fewer members the nearest one of the same kind is too often not there.
MIN_MEMBERS = 12
# Share of the mean variance within categories that is added along each axis, so that no axis counts without bounds.
SHRINKAGE = 0.3
# Rows of the table of distances that are made at a time.
BLOCK = 512


@dataclass(frozen=True)
class CollectedMember:
    """A member by id and category, with the features that identify it: signature, and sides of its box in metres."""

    id: str
    category: str
    signature: Signature
    sides: Vec3


@dataclass(frozen=True)
class CategoryConfusion:
    """How many members of a category are nearer to their own kind than to another one.

    Attributes:
        category: of them. count: of members. right: of those whose nearest neighbour is of their kind.
        others: categories of the other neighbours with their number, the most frequent first.
    """

    category: str
    count: int
    right: int
    others: tuple[tuple[str, int], ...]


@dataclass(frozen=True, eq=False)
class ObjectCollection:
    """Members of categories of objects; compared by identity, so that measurements of it can be cached.

    Attributes:
        members: in the order of the library.
        look_alikes: category -> name shared by categories that look like one kind; categories not listed are separate
            kinds.
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
            far = np.maximum(
                descriptor_distances(shapes, shapes) / SAME_SHAPE, cdist(sides, sides, "chebyshev") / SAME_SIZE
            )
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
    out: Floats = places @ np.linalg.cholesky(np.linalg.inv(covariance))
    return out


def _nearest(places: Floats) -> Iterator[int]:
    """Index of the nearest other point, of each point."""
    from scipy.spatial.distance import cdist

    for start in range(0, len(places), BLOCK):
        far = cdist(places[start : start + BLOCK], places)
        far[np.arange(len(far)), start + np.arange(len(far))] = np.inf
        yield from far.argmin(axis=1).tolist()


# Kinds ----------------------------------------------------------------------------------------------------------------
# Find members of a category that are alike, and categories that are taken for others (OBJ005 to OBJ007).

TOO_FEW = f"there are no two categories of at least {MIN_MEMBERS} members"
# Categories that a message names.
NAMED = 4


def members_differ(collection: ObjectCollection, limit: float) -> Measurement:
    """OBJ005: distance of the two most alike members of a category, over what copies of one thing may differ by."""
    near = collection.nearest_alike
    problems = [
        (own, f"is like {other} in shape, sides and colours ({distance:.2f}); widen what its category draws from")
        for own, other, distance in near
        if distance <= limit
    ]
    return least([distance for _, _, distance in near], problems, "no category has two members")


def members_are_told_apart(collection: ObjectCollection, limit: float) -> Measurement:
    """OBJ006: share of all members whose nearest neighbour is of the same kind."""
    rows = collection.confusions
    if not rows:
        return not_applicable(TOO_FEW)
    share = sum(row.right for row in rows) / sum(row.count for row in rows)
    message = f"{share:.1%} of the members are nearest to their own kind; make those of OBJ007 more like themselves"
    return Measurement(share, () if share >= limit else (("library", message),))


def categories_are_told_apart(collection: ObjectCollection, limit: float) -> Measurement:
    """OBJ007: the same share of each category, the worst; what it is taken for is named."""
    rows = collection.confusions
    problems = [(row.category, in_words(row)) for row in rows if row.right < limit * row.count]
    return least([row.right / row.count for row in rows], problems, TOO_FEW)


def in_words(row: CategoryConfusion) -> str:
    """The kinds that members of a category are confused with, as a clause for messages."""
    named = ", ".join(f"{name} ({count})" for name, count in row.others[:NAMED])
    return (
        f"{row.count - row.right} of {row.count} are nearer to another kind: {named}; tell them apart by form or colour"
    )
