"""Divide a front without seams into one cell per pull, so that pulls lie where doors and drawers have them.

The pull of a drawer is in the middle of its width, that of a door at one of its sides; all pulls of an object have the
same distance from the edge; cells in a row tend to be of one size, and open spaces are separate cells. The partition
consists of cuts from end to end, each of which divides a cell in two (a guillotine partition); the cheapest one is
taken.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

Span = tuple[int, int]
# Most things that are parted, and most cells that are looked at: the number of partitions grows fast where things are
# in no order. Nine fronts in three rows take some 7,000.
MAX_ITEMS, MAX_CELLS = 14, 8_000
# Pixels between two cuts: one, and one more for each of these in the longer side.
GRID = 128
# Costs are squares of deviations by these: of the middle of a pull from that of its cell, by its width or height, and
# of its distance from an edge, by the least side of the cell. Choices.
MIDDLE_SLACK, HEIGHT_SLACK, EDGE_SLACK = 0.06, 0.08, 0.06
# A pull at the side of its cell is at most this share of the width from it.
MAX_SIDE_SHARE = 0.22
# Most that a pull costs for its place across, for its place upwards, and what an unlikely kind of place costs more.
MAX_ACROSS, MAX_UPWARDS, UNLIKELY = 4.0, 0.8, 1.0
# Cost of a pull that is not in the middle of the height, but as far from the top as others, in this upper share of it.
NO_MIDDLE, UPPER_SHARE = 0.1, 0.34
# Cost of not keeping one distance from a side, of two pulls on one drawer, and by the log of the ratio of sizes.
NO_COMMON_DISTANCE, TWO_PULLS, UNEQUAL = 0.3, 0.3, 0.4
# A cell is at most so much higher than wide, or wider than high, at no cost, and what more costs.
MAX_TALL, MAX_WIDE, BY_RATIO = 4.0, 6.0, 0.3
# A pull lies or stands if it is so much longer than wide; a front is low if it is so much wider than high.
LONG, LOW = 1.5, 2.0
# What an open room costs by the share of the sides of its cell that it falls short.
ROOM_MISMATCH = 8.0
# A partition in which a cell costs more than this is none.
MAX_CELL_COST = 2.6


@dataclass(frozen=True)
class Item:
    """A pull or an open room on a front, in half-open pixel ranges.

    Attributes:
        rows, columns: of the pull or room. reach_rows, reach_columns: what no cut may cross: the panel that it is on.
    """

    rows: Span
    columns: Span
    reach_rows: Span
    reach_columns: Span
    is_room: bool = False


@dataclass(frozen=True)
class Cell:
    """A rectangle with one pull, and what its place costs; rooms are left out of what is returned."""

    rows: Span
    columns: Span
    cost: float


@dataclass(frozen=True)
class _Part:
    """A partition of a cell.

    Attributes:
        along: how many cells it has one above the other, and side by side.
        lying: share of its pulls that lie.
    """

    cost: float
    cells: tuple[Cell, ...]
    along: tuple[int, int] = (1, 1)
    lying: float = 0.0


def part_between_pulls(rows: Span, columns: Span, items: Sequence[Item]) -> list[Cell]:
    """Return the cells of the cheapest partition of a rectangle into one cell per pull, from top to bottom.

    Returns:
        The cells; empty for fewer than two pulls, if there is no such partition, if one of its cells is an unlikely
        front, or if there are too many items or cells to try.
    """
    pulls = [i for i in items if not i.is_room]
    if len(pulls) < 2 or len(items) > MAX_ITEMS:
        return []
    best: _Part | None = None
    top = tuple(_top_distance(rows, [p for p in pulls if _lies(p) is lies]) for lies in (False, True))
    standing = [p for p in pulls if not _lies(p)]
    ends = {min(p.columns[0] for p in standing) - columns[0]} if standing else set()
    ends |= {columns[1] - max(p.columns[1] for p in standing)} if standing else set()
    for side in [None, *sorted(e for e in ends if e < MAX_SIDE_SHARE * (columns[1] - columns[0]))]:
        cost = NO_COMMON_DISTANCE * (side is None)
        search = _Search(tuple(items), top, side, 1 + max(_size(rows), _size(columns)) // GRID)
        part = search.best(rows, columns, tuple(range(len(items))))
        if len(search.known) >= MAX_CELLS:
            return []
        if part is not None and (best is None or part.cost + cost < best.cost):
            best = _Part(part.cost + cost, part.cells)
    if best is None or max(c.cost for c in best.cells) > MAX_CELL_COST:
        return []
    return sorted(best.cells, key=lambda c: (c.rows, c.columns))


def _top_distance(rows: Span, pulls: Sequence[Item]) -> int | None:
    """Return the distance from the top that pulls in several rows may all have; None if all are in one row."""
    tops = [p.rows[0] for p in pulls]
    several = len(tops) > 1 and max(tops) - min(tops) > max(_size(p.rows) for p in pulls)
    return min(tops) - rows[0] if several else None


def _size(span: Span) -> int:
    return span[1] - span[0]


def _middle(span: Span) -> float:
    return (span[0] + span[1]) / 2


def _lies(item: Item) -> bool:
    """Return whether a pull is wider than high."""
    return _size(item.columns) > LONG * _size(item.rows)


def _stands(item: Item) -> bool:
    """Return whether a pull is higher than wide."""
    return _size(item.rows) > LONG * _size(item.columns)


@dataclass
class _Search:
    """Search for the cheapest partition into cells, for pulls at given distances from the top and a side of a cell.

    Attributes:
        top: distance from the top, of pulls that are not wider than high, and of those that are. side: distance from a
            side, of pulls that are higher than wide.
        grid: cuts lie at multiples of this number of pixels.
    """

    items: tuple[Item, ...]
    top: tuple[int | None, ...]
    side: int | None
    grid: int
    known: dict[tuple[Span, Span], _Part | None] = field(default_factory=dict)

    def best(self, rows: Span, columns: Span, inside: tuple[int, ...]) -> _Part | None:
        """Return the cheapest partition of a cell, or None if none is found."""
        key = rows, columns
        if key not in self.known:
            if len(self.known) >= MAX_CELLS:
                return None
            self.known[key] = None
            best = self._leaf(rows, columns, inside)
            for axis, at in self._cuts(rows, columns, inside) if len(inside) > 1 else ():
                part = self._cut(rows, columns, inside, axis, at, math.inf if best is None else best.cost)
                if part is not None and (best is None or part.cost < best.cost - 1e-9):
                    best = part
            self.known[key] = best
        return self.known[key]

    def _cut(self, rows: Span, columns: Span, inside: tuple[int, ...], axis: int, at: int, most: float) -> _Part | None:
        """Return the cheapest partition of a cell that is cut at a row (axis 0) or a column (axis 1).

        Args:
            most: what costs more is not looked at.
        """
        spans = [self._reach(i, axis) for i in inside]
        ends = (rows, columns)[axis]
        halves = (ends[0], at), (at, ends[1])
        parts: list[_Part] = []
        for half in halves:
            mine = tuple(i for i, s in zip(inside, spans, strict=True) if half[0] <= s[0] and s[1] <= half[1])
            part = self.best(half, columns, mine) if axis == 0 else self.best(rows, half, mine)
            if part is None or part.cost + sum(p.cost for p in parts) >= most:
                return None
            parts.append(part)
        one, other = parts
        each = [_size(h) / p.along[axis] for h, p in zip(halves, (one, other), strict=True)]
        count = one.along[axis] + other.along[axis]
        # Drawers are as high as drawers, but lower than the doors under them.
        weight = UNEQUAL if axis == 1 else UNEQUAL * max(0.0, 1.0 - abs(one.lying - other.lying))
        cost = one.cost + other.cost + weight * abs(math.log(each[0] / each[1]))
        lying = (one.lying * len(one.cells) + other.lying * len(other.cells)) / max(
            len(one.cells) + len(other.cells), 1
        )
        return _Part(cost, one.cells + other.cells, (count, 1) if axis == 0 else (1, count), lying)

    def _reach(self, i: int, axis: int) -> Span:
        """Return the range of rows (axis 0) or columns that no cut may cross at an item."""
        return (self.items[i].reach_rows, self.items[i].reach_columns)[axis]

    def _cuts(self, rows: Span, columns: Span, inside: tuple[int, ...]) -> Iterator[tuple[int, int]]:
        """Yield the axis and place of each cut of a cell that may be best: between items, so that cells suit them."""
        for axis, ends in enumerate((rows, columns)):
            spans = sorted(self._reach(i, axis) for i in inside)
            reach = spans[0][1]
            for lower, upper in spans[1:]:
                if lower >= reach:
                    yield from ((axis, at) for at in sorted(self._places(axis, ends, (reach, lower), inside)))
                reach = max(reach, upper)

    def _places(self, axis: int, ends: Span, gap: Span, inside: tuple[int, ...]) -> set[int]:
        """Return where a cut in a gap may lie: its middle, equal shares, and where pulls have their usual places."""
        found = [_middle(gap)]
        found += [ends[0] + k / n * _size(ends) for n in (2, 3, 4) for k in range(1, n)]
        for i in self._beside(axis, gap, inside):
            item = self.items[i]
            own = (item.rows, item.columns)[axis]
            if item.is_room:
                found += own
                continue
            found += [2 * _middle(own) - ends[0], 2 * _middle(own) - ends[1]]
            top = self.top[_lies(item)]
            if axis == 0 and top is not None:
                found.append(own[0] - top)
            elif axis == 1 and self.side is not None:
                found += [own[0] - self.side, own[1] + self.side]
        snapped = {round(at / self.grid) * self.grid for at in found}
        return {at for at in snapped if max(gap[0], ends[0] + 2) <= at <= min(gap[1], ends[1] - 2)}

    def _beside(self, axis: int, gap: Span, inside: tuple[int, ...]) -> list[int]:
        """Return the items that lie right before and right behind a gap, with those in line with them."""
        before = [i for i in inside if self._reach(i, axis)[1] <= gap[0]]
        after = [i for i in inside if self._reach(i, axis)[0] >= gap[1]]
        last = max(_middle(self._reach(i, axis)) for i in before)
        first = min(_middle(self._reach(i, axis)) for i in after)
        slack = max(_size(self._reach(i, axis)) for i in (*before, *after)) / 2
        near = [i for i in before if _middle(self._reach(i, axis)) >= last - slack]
        return near + [i for i in after if _middle(self._reach(i, axis)) <= first + slack]

    def _leaf(self, rows: Span, columns: Span, inside: tuple[int, ...]) -> _Part | None:
        """Return a cell as it is: of a pull, of two pulls of one drawer, or of a room; None of anything else."""
        items = [self.items[i] for i in inside]
        if len(items) == 1 and items[0].is_room:
            short = sum(abs(a - b) for a, b in zip((*rows, *columns), (*items[0].rows, *items[0].columns), strict=True))
            return _Part(ROOM_MISMATCH * short / (_size(rows) + _size(columns)), ())
        if len(items) == 1:
            cost = self._across(columns, items[0], _size(rows)) + self._upwards(rows, items[0])
        elif len(items) == 2 and not any(i.is_room for i in items):
            cost = self._pair(rows, columns, items[0], items[1])
        else:
            return None
        ratio = _size(columns) / _size(rows)
        cost += BY_RATIO * max(0.0, ratio - MAX_WIDE, 1.0 / ratio - MAX_TALL)
        lying = sum(_lies(i) for i in items) / len(items)
        return _Part(cost, (Cell(rows, columns, cost),), lying=lying)

    def _across(self, columns: Span, pull: Item, height: int) -> float:
        """Return what the place of a pull in the width of its cell costs."""
        width = _size(columns)
        middle = ((_middle(pull.columns) - _middle(columns)) / width / MIDDLE_SLACK) ** 2
        away = min(pull.columns[0] - columns[0], columns[1] - pull.columns[1])
        edge = (max(0.0, away / width - MAX_SIDE_SHARE) / EDGE_SLACK) ** 2
        if self.side is not None:
            edge += ((away - self.side) / min(width, height) / EDGE_SLACK) ** 2
        middle += UNLIKELY * _stands(pull)
        # A front that is much wider than high is a drawer.
        edge += UNLIKELY * (_lies(pull) + (width > LOW * height))
        return min(middle, edge, MAX_ACROSS)

    def _upwards(self, rows: Span, pull: Item) -> float:
        """Return what the place of a pull in the height of its cell costs: doors have them anywhere."""
        height = _size(rows)
        found = [((_middle(pull.rows) - _middle(rows)) / height / HEIGHT_SLACK) ** 2, MAX_UPWARDS]
        away, top = pull.rows[0] - rows[0], self.top[_lies(pull)]
        if top is not None and away < UPPER_SHARE * height:
            found.append(NO_MIDDLE + ((away - top) / height / HEIGHT_SLACK) ** 2)
        return min(found) * (0.4 if _stands(pull) else 1.0)

    def _pair(self, rows: Span, columns: Span, one: Item, other: Item) -> float:
        """Return what two pulls of one drawer cost: side by side, each as far from the middle."""
        width, height = _size(columns), _size(rows)
        if width < height or _stands(one) or _stands(other):
            return 2 * MAX_ACROSS
        middle = (_middle(one.columns) + _middle(other.columns)) / 2
        level = abs(_middle(one.rows) - _middle(other.rows)) / height / MIDDLE_SLACK
        apart = abs(_middle(one.columns) - _middle(other.columns)) / width
        cost = ((middle - _middle(columns)) / width / MIDDLE_SLACK) ** 2 + level**2 + self._upwards(rows, one)
        return cost + TWO_PULLS + (MAX_ACROSS if not 0.3 <= apart <= 0.75 else 0.0)
