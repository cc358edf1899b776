"""Exclusion -> `<exclude>` between two bodies."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf.body import Draft
from casa_assets.model.asset import Exclusion


def add(contact: etree._Element, exclusion: Exclusion, draft: Draft | None = None) -> None:
    """`<exclude>` below `<contact>`; a draft names the bodies and what the name begins with."""
    first, second = exclusion.first, exclusion.second
    name = f"{first}__{second}"
    if draft is not None:
        name, first, second = draft.prefix + name, draft.body_name(first), draft.body_name(second)
    etree.SubElement(contact, "exclude", {"name": name, "body1": first, "body2": second})
