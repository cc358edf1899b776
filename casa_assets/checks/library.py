"""Checks on all assets of a library together: duplicates, and sizes unlike those of others of their category."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.checks.check import Check, Measurement, Row, no_fault, not_applicable, not_run, worst_above
from casa_assets.model.issue import Severity

MIN_ASSETS = 5  # with fewer assets of a category nobody knows which one is odd
MIN_SCATTER = 1.1  # the least scatter of the sizes of a category, as a ratio: mugs of a set differ by as much
SIGMA_PER_MAD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
# How many times the limit for the 95th percentile of the distance the 99.5th of two copies may be.
EVERY_SHARE = 4.0
# Two copies differ in size by at most this ratio, and in colours by at most this distance in CIELAB.
SAME_SIZE, SAME_COLORS = 0.03, 4.0
# Other categories that messages name.
NAMED = 3
ALONE = "there are no two assets to compare"
ERROR, WARNING = Severity.ERROR, Severity.WARNING


@dataclass(frozen=True)
class LibrarySizes:
    """(id, category, longest side in metres) of the assets of a library."""

    rows: tuple[tuple[str, str, float], ...]


def sizes_fit_their_category(sizes: LibrarySizes, limit: float) -> Measurement:
    """LIB004: robust deviations of the oddest longest side from the median of its category.

    Ref: Iglewicz and Hoaglin 1993, the modified z score, here of logarithms; they call outliers what is beyond 3.5.
    """
    by_category: dict[str, list[tuple[str, float]]] = {}
    for name, category, longest in sizes.rows:
        by_category.setdefault(category, []).append((name, longest))
    rows: list[Row] = []
    for category, members in sorted(by_category.items()):
        if len(members) < MIN_ASSETS:
            continue
        logs = np.log([longest for _, longest in members])
        middle = float(np.median(logs))
        scatter = max(SIGMA_PER_MAD * float(np.median(np.abs(logs - middle))), float(np.log(MIN_SCATTER)))
        for (name, longest), deviation in zip(members, np.abs(logs - middle) / scatter, strict=True):
            message = f"is {longest:.3g} m long, and {np.exp(middle):.3g} m is usual for a {category} here"
            rows.append((name, float(deviation), f"{message}; look at its unit and its category"))
    return worst_above(rows, limit, f"no category has {MIN_ASSETS} assets to compare")


@dataclass(frozen=True)
class ShapePair:
    """Two assets of nearly one shape, in the order of the library.

    `p95`, `p995`: percentiles of the distance from either surface to the other once they are aligned, as a part of the
    radius. `size`: of the other over the one. `colors`: how far their colours are apart, CIELAB units.
    """

    one: str
    other: str
    p95: float
    p995: float
    size: float
    colors: float
    same_category: bool

    def same_form(self, limit: float) -> bool:
        """One shape at one size or at two."""
        return self.p95 <= limit and self.p995 <= EVERY_SHARE * limit

    def twins(self, limit: float) -> bool:
        """One thing: form and colours agree, and the size too, unless two names for one mesh give it two sizes."""
        same_size = abs(self.size - 1) <= SAME_SIZE or not self.same_category
        return self.same_form(limit) and self.colors <= SAME_COLORS and same_size


@dataclass(frozen=True)
class CategoryRank:
    """Categories that a vision-language model sees in the pictures of an asset.

    `share`, `rank`: of its own category among all; rank 0: it has none to compare. `others`: the likeliest, best first.
    """

    asset: str
    category: str
    share: float
    rank: int
    others: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class LibraryView:
    """The accepted assets of a library: pairs of nearly one form, pairs with cosines near 1, what each looks like.

    `unseen`: why nobody looked at the pictures; empty where somebody did.
    """

    count: int
    alike: tuple[ShapePair, ...] = ()
    looks: tuple[tuple[str, str, float], ...] = ()
    seen: tuple[CategoryRank, ...] = ()
    unseen: str = ""


def shapes_are_unique(view: LibraryView, limit: float) -> Measurement:
    """LIB001: distance of the two most alike surfaces, as a part of their radius."""
    problems = []
    for pair in view.alike:
        if pair.same_form(limit):
            size = f"{pair.size:.2f} times as large" if abs(pair.size - 1) > SAME_SIZE else "of the same size"
            color = "in the same colours" if pair.colors <= SAME_COLORS else "in other colours"
            alike = f"has the form of {pair.one}, {size}, {color}"
            problems.append((pair.other, f"{alike}; keep one of them, or both if that is meant"))
    if view.count < 2:
        return not_applicable(ALONE)
    # Pairs whose forms are far apart are not compared point by point: where all are, there is no number.
    return Measurement(min(pair.p95 for pair in view.alike), tuple(problems)) if view.alike else no_fault()


def looks_are_unique(view: LibraryView, limit: float) -> Measurement:
    """LIB002: largest cosine between the picture embeddings of two assets."""
    if view.unseen:
        return not_run(view.unseen)
    alike, advice = (row for row in view.looks if row[2] >= limit), "keep one of them, or both if that is meant"
    problems = [(other, f"looks like {one} to a model (cosine {near:.3f}); {advice}") for one, other, near in alike]
    if view.count < 2:
        return not_applicable(ALONE)
    return Measurement(max(near for _, _, near in view.looks), tuple(problems)) if view.looks else no_fault()


def looks_match_categories(view: LibraryView, limit: float) -> Measurement:
    """LIB003: rank of an asset's own category among all that CLIP sees in it; the worst."""
    if view.unseen:
        return not_run(view.unseen)
    advice = "look at the picture, and fix the category or leave it out"
    rows = ((one.asset, float(one.rank), f"{in_words(one)}; {advice}") for one in view.seen if one.rank)
    return worst_above(rows, limit, "no asset has a category to compare its picture with")


def in_words(one: CategoryRank) -> str:
    """The look of an asset as a clause for messages."""
    named = ", ".join(f"{name} ({share:.0%})" for name, share in one.others[:NAMED])
    if not one.rank:
        return f"looks like {named}; it has no category to compare with"
    return f"is called {one.category} ({one.share:.0%}, number {one.rank} of what it looks like); others: {named}"


# fmt: off
ROWS: tuple[Check, ...] = (
    Check("LIB001", "No duplicate shapes", WARNING, LibraryView, shapes_are_unique, "alike_form", "",
          "No two assets have the same shape, which means that 95 % of each surface lies within {limit:g} radii of the "
          "other; keep one of the two, or both if you want both."),
    Check("LIB002", "No duplicate looks", WARNING, LibraryView, looks_are_unique, "alike_look", "",
          "No two assets look alike to CLIP: the cosine of their pictures is below {limit:g}; keep one of them, or "
          "both if you want both."),
    Check("LIB003", "Looks like its category", WARNING, LibraryView, looks_match_categories, "look_rank", "",
          "CLIP ranks an asset's category among its first {limit:g} names for the picture; correct the category, or "
          "leave the asset out."),
    Check("LIB004", "Size among its category", WARNING, LibrarySizes, sizes_fit_their_category, "size_off", "",
          "The longest side is within {limit:g} robust deviations of the median of its category in the library; check "
          "its unit and its category."),
)
# fmt: on
