"""The page of review for the articulated meshes of a library, made from its entries alone."""

from __future__ import annotations

from collections.abc import Sequence

from casa_assets.pipeline.articulate.review_page import render_page
from casa_assets.pipeline.articulate.run import outcome_of_entry
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.reports.entry import Entry

COMMAND = "casa-assets articulate SOURCES --library {library}"


def articulated_page(library: Library, entries: Sequence[Entry]) -> str:
    """Return the HTML of the page; entries of which no record is left are not on it."""
    found = [outcome for entry in entries if (outcome := outcome_of_entry(library, entry)) is not None]
    return render_page(library, found, COMMAND.format(library=library.root), is_served=True)
