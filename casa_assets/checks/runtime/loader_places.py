"""Read regions and sites of a model.xml by the arithmetic of the reference runtime's loader, and compare with MuJoCo's.

Ref: RoboCasa v1.0, models/fixtures: Fixture takes the `pos` and `size` that are written on a region's geom for a box on
the fixture itself, whatever body the geom is in; get_reset_regions puts things on its lower side, if that is within
heights above the floor; anchor_offset is the `pos` of a site next to the body `object`, under the same parent; Sink
looks for `water` in its basins.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from lxml import etree

from casa_assets.checks.check import Problem
from casa_assets.checks.readers.mujoco_facts import load_mjcf
from casa_assets.core.numeric import Floats
from casa_assets.model.registry.contract import Contract, PlaceRule

PREFIX = "reg_"
OUTER = "main"
# Rounding of what nine written digits hold, and of sums of lengths.
SLACK_M = 1e-4
# A cube of this edge is put into the middle of a region, from this far above its lower side; where nothing is that
# far below that side, it falls.
CUBE_M, LIFT_M, MAX_FALL_M = 0.05, 0.015, 0.02


@dataclass(frozen=True)
class ReadRegion:
    """A region as the loader reads it: its corners on the fixture, metres, and the body that its geom is in."""

    lower: Floats
    upper: Floats
    body: str

    @property
    def middle(self) -> Floats:
        """Its middle on the fixture, metres."""
        return (self.lower + self.upper) / 2


def faults(path: Path, contract: Contract) -> Iterator[Problem]:
    """(pointer, message) of everything that the loader finds elsewhere than it is in the model, or not at all.

    Reports nothing that other checks report: a file that does not compile (MJC001), without `object` (CON005), without
    regions of a name (CON004).
    """
    model = load_mjcf(path).model
    if model is None or mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "object") < 0:
        return
    root = etree.parse(str(path)).getroot()
    regions = read_regions(root)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    origin = data.body("object").xpos
    for name, region in regions.items():
        off = float(np.linalg.norm(data.geom(PREFIX + name).xpos - origin - region.middle))
        if off > SLACK_M:
            message = f"is {off:.4f} m from where RoboCasa takes it to be; its body's frame should be that of object"
            yield f"model.xml/geom/{PREFIX}{name}", message
    for rule in contract.places:
        yield from _missing_places(model, data, regions, rule)
    for name in contract.beside:
        site = root.find(f"./worldbody/body/site[@name='{name}']")
        if site is None or site.get("pos") is None:
            yield f"model.xml/site/{name}", "is not at worldbody/body/site with a pos, where RoboCasa looks"
    for site_name, pattern in contract.falls_into.items():
        yield from _beside_all(data, regions, site_name, pattern)


def read_regions(root: etree._Element) -> dict[str, ReadRegion]:
    """Name without `reg_` -> region, of all geoms that the loader takes for regions."""
    found = {}
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            name = geom.get("name", "")
            if name.startswith(PREFIX):
                middle, half = _numbers(geom, "pos"), _numbers(geom, "size")
                if geom.get("type") == "cylinder":
                    half = np.array([half[0], half[0], half[1]])
                found[name.removeprefix(PREFIX)] = ReadRegion(middle - half, middle + half, body.get("name", ""))
    return found


def _numbers(element: etree._Element, attribute: str) -> Floats:
    return np.array([float(n) for n in element.get(attribute, "").split()])


def _missing_places(
    model: mujoco.MjModel, data: mujoco.MjData, regions: Mapping[str, ReadRegion], rule: PlaceRule
) -> Iterator[Problem]:
    """Places that RoboCasa offers in too small a number, that move, or that have nothing under them."""
    foot = float(regions[OUTER].lower[2]) if OUTER in regions else 0.0
    top = float(regions[OUTER].upper[2]) if OUTER in regions else 0.0
    stands = rule.stands_m - (top if rule.let_in else foot)
    offered = 0
    named = {name: region for name, region in regions.items() if re.fullmatch(rule.regions, name)}
    for name, region in named.items():
        if region.upper[2] - region.lower[2] < rule.min_height_m:
            continue
        pointer, height = f"model.xml/geom/{PREFIX}{name}", stands + float(region.lower[2])
        if rule.fixed and region.body != "object":
            yield pointer, f"is in the body {region.body!r}, which moves; RoboCasa takes it for a shelf"
        if rule.heights_m is None or rule.heights_m[0] <= height <= rule.heights_m[1]:
            offered += 1
        if not _holds(model, data, region):
            below = f"has nothing within {MAX_FALL_M:g} m below the middle of its lower side"
            yield pointer, f"{below}; what is put there falls"
    if named and offered < rule.min_count:
        yield "model.xml/geom", f"{offered} regions {rule.regions!r} are where things are put, {rule.min_count} wanted"


def _holds(model: mujoco.MjModel, data: mujoco.MjData, region: ReadRegion) -> bool:
    """True if something is under a cube in the middle of a region's lower side."""
    edge = min(CUBE_M, *(0.75 * (region.upper - region.lower)[:2]))
    start = data.body("object").xpos + np.array([*region.middle[:2], region.lower[2] + LIFT_M])
    groups, geom = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8), np.zeros(1, dtype=np.int32)
    for x in np.linspace(-edge / 2, edge / 2, 5):
        for y in np.linspace(-edge / 2, edge / 2, 5):
            point = start + np.array([x, y, 0.0])
            reach = mujoco.mj_ray(model, data, point, [0.0, 0.0, -1.0], groups, 1, -1, geom)
            if 0.0 <= reach <= LIFT_M + MAX_FALL_M:
                return True
    return False


def _beside_all(data: mujoco.MjData, regions: Mapping[str, ReadRegion], site: str, pattern: str) -> Iterator[Problem]:
    if mujoco.mj_name2id(data.model, mujoco.mjtObj.mjOBJ_SITE, site) < 0:
        yield f"model.xml/site/{site}", f"is missing; it has to be above one of the regions {pattern!r}"
        return
    at = (data.site(site).xpos - data.body("object").xpos)[:2]
    into = [region for name, region in regions.items() if re.fullmatch(pattern, name)]
    if not any((region.lower[:2] < at).all() and (at < region.upper[:2]).all() for region in into):
        yield f"model.xml/site/{site}", f"is above none of the regions {pattern!r} with the joints at zero"
