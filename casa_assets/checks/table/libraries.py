"""Checks of a library as a whole."""

from __future__ import annotations

from casa_assets.checks import library
from casa_assets.checks.check import Check
from casa_assets.checks.library import LibrarySizes, LibraryView
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
    Check("LIB001", "No duplicate shapes", WARNING, LibraryView, library.shapes_are_unique, "alike_form", "",
          "No two assets have the same shape, which means that 95 % of each surface lies within {limit:g} radii of "
          "the other; keep one of the two, or both if you want both."),
    Check("LIB002", "No duplicate looks", WARNING, LibraryView, library.looks_are_unique, "alike_look", "",
          "No two assets look alike to CLIP: the cosine of their pictures is below {limit:g}; keep one of them, or "
          "both if you want both."),
    Check("LIB003", "Looks like its category", WARNING, LibraryView, library.looks_match_categories, "look_rank", "",
          "CLIP ranks an asset's category among its first {limit:g} names for the picture; correct the category, or "
          "leave the asset out."),
    Check("LIB004", "Size among its category", WARNING, LibrarySizes, library.sizes_fit_their_category,
          "size_off", "",
          "The longest side is within {limit:g} robust deviations of the median of its category in the library; check "
          "its unit and its category."),
)
# fmt: on
