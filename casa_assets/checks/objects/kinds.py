"""Find members of a category that are alike, and categories that are taken for others (OBJ005 to OBJ007)."""

from __future__ import annotations

from casa_assets.checks.check import Measurement, least, not_applicable
from casa_assets.checks.objects.collection import MIN_MEMBERS, CategoryConfusion, ObjectCollection

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
