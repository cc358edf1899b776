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
    """A number that something is held against, with its unit (empty for counts and ratios) and one line of why."""

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
    """Words that mislead a look-up: `weak` ones yield to any other, `separators` end the name of a thing in a text."""

    weak: tuple[str, ...]
    separators: tuple[str, ...]


class OtherThingsWords(Record):
    """Words in names which tell that a mesh is no single household object, singular; see registry/other_things.yaml.

    Attributes:
        always: count beside the name of any category. parts: count as the last word of a name.
        figures, places, shapes, outdoors, arms: count where the name speaks of no category.
    """

    always: tuple[str, ...]
    parts: tuple[str, ...]
    figures: tuple[str, ...]
    places: tuple[str, ...]
    shapes: tuple[str, ...]
    outdoors: tuple[str, ...]
    arms: tuple[str, ...]
