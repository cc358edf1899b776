"""Small rows of registry/: classes of categories, limits, reasons for rejections, waivers, words that mislead."""

from __future__ import annotations

from casa_assets.model.issue import Code
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.category import QCode


class TaxonomyClass(Record):
    """A class of categories or of classes; `parent` is None at the root."""

    id: Id
    parent: Id | None = None
    qcode: QCode


class Limit(Record):
    """A limit for measured values, with its unit (empty for counts and ratios) and its reason in one line."""

    id: Id
    value: float
    unit: str = ""
    why: str


class Rejection(Record):
    """Reason for turning an input away: its meaning and the remedy, for the person who sent it."""

    code: Code
    name: Id
    meaning: str
    remedy: str


class Waiver(Record):
    """A fault of one subject that is known and accepted, with the reason."""

    code: Code
    subject: str
    reason: str


class MisleadingWords(Record):
    """Words that mislead a look-up.

    Attributes:
        weak: words that yield to any other word.
        separators: words that end the name of the object in a text.
    """

    weak: tuple[str, ...]
    separators: tuple[str, ...]


class OtherThingsWords(Record):
    """Words in names which show that a mesh is not a single household object; see registry/other_things.yaml.

    All words are in the singular.

    Attributes:
        always: count even if the name contains a category.
        parts: count as the last word of a name.
        figures, places, shapes, outdoors, arms: count if the name contains no category.
    """

    always: tuple[str, ...]
    parts: tuple[str, ...]
    figures: tuple[str, ...]
    places: tuple[str, ...]
    shapes: tuple[str, ...]
    outdoors: tuple[str, ...]
    arms: tuple[str, ...]
