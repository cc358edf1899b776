"""Exclusion -> `<exclude>` between two bodies."""

from __future__ import annotations

from lxml import etree

from casa_assets.model.asset import Exclusion


def add(contact: etree._Element, exclusion: Exclusion) -> None:
    """`<exclude>` below `<contact>`."""
    first, second = exclusion.first, exclusion.second
    etree.SubElement(contact, "exclude", {"name": f"{first}__{second}", "body1": first, "body2": second})
