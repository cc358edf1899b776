"""Exclusion -> `<exclude>` between two bodies."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf.body import BodyContext
from casa_assets.model.asset.asset import Exclusion


def add(contact: etree._Element, exclusion: Exclusion, draft: BodyContext | None = None) -> None:
    """`<exclude>` below `<contact>`; a draft names the bodies and what the name begins with."""
    first, second = exclusion.first, exclusion.second
    name = f"{first}__{second}"
    if draft is not None:
        name, first, second = draft.prefix + name, draft.body_name(first), draft.body_name(second)
    etree.SubElement(contact, "exclude", {"name": name, "body1": first, "body2": second})


def exclude(contact: etree._Element, first: str, second: str) -> None:
    """`<exclude>` of two bodies of a scene by their names, of which it makes its own."""
    etree.SubElement(contact, "exclude", {"name": f"{first}__beside__{second}", "body1": first, "body2": second})


def exclude_from_world(body: etree._Element, moved: bool = False) -> None:
    """Exclude contacts between what is fixed to the world and what moves on it, below a fixed body.

    A door and the frames, walls and worktops around it are near each other all the time, so that looking whether they
    touch is half of all work, and they never do: that nothing runs into anything over the whole range of its joint is
    checked of every scene. Doors still meet doors, and everything meets robots and loose things, whose bits are 1 and 1
    as MuJoCo has them by default.
    """
    moved = moved or body.find("joint") is not None
    for geom in [g for g in body.findall("geom") if g.get("contype") == "1"]:
        contype, conaffinity = ("3", "2") if moved else ("1", "0")
        geom.set("contype", contype)
        geom.set("conaffinity", conaffinity)
    for carried in body.findall("body"):
        exclude_from_world(carried, moved)
