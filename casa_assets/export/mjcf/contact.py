"""Exclusion -> `<exclude>` between two bodies."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf.body import BodyContext
from casa_assets.model.asset.asset import Exclusion


def add(contact: etree._Element, exclusion: Exclusion, context: BodyContext | None = None) -> None:
    """`<exclude>` below `<contact>`; `context` gives the bodies their names in a scene."""
    first, second = exclusion.first, exclusion.second
    name = f"{first}__{second}"
    if context is not None:
        name, first, second = context.prefix + name, context.body_name(first), context.body_name(second)
    etree.SubElement(contact, "exclude", {"name": name, "body1": first, "body2": second})


def exclude(contact: etree._Element, first: str, second: str) -> None:
    """`<exclude>` for two bodies of a scene, named after both."""
    etree.SubElement(contact, "exclude", {"name": f"{first}__beside__{second}", "body1": first, "body2": second})


def exclude_from_world(body: etree._Element, is_moved: bool = False) -> None:
    """Exclude contacts between parts that are fixed to the world and moving parts on them, below a fixed body.

    A door is always near the frames, walls and worktops around it, so that half of all collision tests would be spent
    on pairs that never touch: a check of every scene makes sure that no joint runs into anything over its whole range.
    Doors still collide with doors, and everything collides with robots and loose objects, whose contype and conaffinity
    are 1, MuJoCo's default.

    Args:
        body: a fixed body, or with `is_moved` a body that a joint carries.
    """
    is_moved = is_moved or body.find("joint") is not None
    for geom in [g for g in body.findall("geom") if g.get("contype") == "1"]:
        contype, conaffinity = ("3", "2") if is_moved else ("1", "0")
        geom.set("contype", contype)
        geom.set("conaffinity", conaffinity)
    for carried in body.findall("body"):
        exclude_from_world(carried, is_moved)
