"""Checks of objects out of numbers: of each member of a category, and of all members together."""

from __future__ import annotations

from casa_assets.checks.check import Check
from casa_assets.checks.objects import collection, members
from casa_assets.checks.objects.collection import ObjectCollection
from casa_assets.checks.objects.members import ObjectMember
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
    Check("OBJ001", "Sides of the category", ERROR, ObjectMember, members.sides_fit_category, "side_slack", "",
          "Each of the three sides is within a factor {limit:g} of the range that is usual for the category; change "
          "the numbers that the member is drawn from, or the range where it is wrong."),
    Check("OBJ002", "Letters at 20 cm", ERROR, ObjectMember, members.letters_are_large, "letter_seen_px", "px",
          "The brand and the first word on a label are at least {limit:g} pixels high for a camera of 640 pixels and "
          "60 degrees at 20 cm, face it and are not mirrored; enlarge the letters."),
    Check("OBJ003", "Letters in the picture", ERROR, ObjectMember, members.letters_are_resolved, "letter_px", "px",
          "The brand and the first word are at least {limit:g} pixels high in the picture that is laid on; enlarge the "
          "letters, or shorten the line."),
    Check("OBJ004", "Letters on their ground", ERROR, ObjectMember, members.letters_stand_out, "letter_contrast", "",
          "The contrast ratio of the brand and the first word to what is around them is at least {limit:g}; change one "
          "of the two colours."),
    Check("OBJ005", "Members differ", WARNING, ObjectCollection, collection.members_differ, "members_apart", "",
          "No two members of a category look like copies: some difference in shape, sides or colours is more than "
          "{limit:g} times that of two copies of one thing; widen the ranges that the category draws from."),
    Check("OBJ006", "Categories can be told apart", WARNING, ObjectCollection, collection.members_are_told_apart,
          "kind_share", "",
          "For at least {limit:.0%} of all members the most similar other member, by shape, sides and colours, is of "
          "their own category or of one that looks the same; change the categories that OBJ007 names."),
    Check("OBJ007", "Each category can be told apart", WARNING, ObjectCollection,
          collection.categories_are_told_apart, "kind_share", "",
          "In each category the most similar other member is of that category for at least {limit:.0%} of the members; "
          "change its form or its colours, or those of the category that it is confused with."),
)
# fmt: on
