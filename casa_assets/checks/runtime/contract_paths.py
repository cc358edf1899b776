"""Find elements of a model.xml that the reference runtime would miss: literal paths, fixed depths.

Ref: RoboCasa v0.2 and v1.0, models/fixtures: Stove.knob_joints and burner_sites, Sink.handle_joint and water_site,
CoffeeMachine; Fixture reads `ext_*` sites (v0.2) or `reg_*` geoms (v1.0); ranges are read from the element.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from lxml import etree

from casa_assets.checks.check import Problem
from casa_assets.checks.runtime import contract_names as names
from casa_assets.model.asset.asset import Asset
from casa_assets.model.registry.contract import Contract, Requirements, ShapeRule

OBJECT = "./worldbody/body/body[@name='object']"
CORNERS = ("p0", "px", "py", "pz")
TOUCHED = "0"  # group of what collides


def faults(path: Path, asset: Asset, contract: Contract) -> Iterator[Problem]:
    """(pointer, message) of everything that a runtime would not find.

    The file is well-formed and compiles: see MJC001.
    """
    root = _read(path)
    body = None if root is None else root.find(OBJECT)
    if root is None or body is None:
        yield "model.xml", "has no worldbody/body/body called object"
        return
    if any(float(n) != 0.0 for n in body.get("pos", "0").split()) or body.get("quat") is not None:
        yield "model.xml/object", "is moved or turned; RoboCasa takes places on it as places on the fixture"
    if root.find("actuator") is not None:
        yield "model.xml/actuator", "should not be there: RoboCasa would hand it to the robot's controller"
    for needs in met(asset, contract):
        yield from _joints(root, asset, needs)
        yield from _sites(root, asset, needs)
        yield from _geoms(root, asset, needs)
    yield from _regions(root, body, asset)


def met(asset: Asset, contract: Contract) -> list[Requirements]:
    """All needs that apply to the asset: its own, the nearest set of each choice, and those of each value in use."""
    found: list[Requirements] = [contract]
    looks = (names.links_and_joints, names.sites, names.shapes, names.regions)
    for choice in contract.one_of:
        found.append(min(choice.any_of, key=lambda needs: sum(len(look(asset, needs)) for look in looks)))
    for each in contract.for_each:
        found += [each.needs.filled(each.key, value) for value in names.in_use(asset, contract, each.key)]
    return found


def _read(path: Path) -> etree._Element | None:
    try:
        return etree.parse(str(path)).getroot()
    except etree.XMLSyntaxError:
        return None


def _joints(root: etree._Element, asset: Asset, needs: Requirements) -> Iterator[Problem]:
    for rule in needs.joints:
        for joint in asset.joints:
            if not rule.matches(joint.name) or rule.depth is None:
                continue
            where = "./worldbody/body/body" + "/body" * rule.depth + "/joint"
            element = root.find(f"{where}[@name='{joint.name}']")
            if element is None:
                yield f"model.xml/joint/{joint.name}", f"is not at {where[2:]}, where RoboCasa looks"
            elif len(element.get("range", "").split()) != 2:
                yield f"model.xml/joint/{joint.name}", "says no range; RoboCasa reads it from the element"


def _sites(root: etree._Element, asset: Asset, needs: Requirements) -> Iterator[Problem]:
    for rule in needs.sites:
        for site in asset.sites:
            if not rule.matches(site.name) or rule.depth is None:
                continue
            where = "./worldbody/body/body" + "/body" * rule.depth + "/site"
            element = root.find(f"{where}[@name='{site.name}']")
            if element is None:
                yield f"model.xml/site/{site.name}", f"is not at {where[2:]}, where RoboCasa looks"
            elif element.get("pos") is None or element.get("size") is None:
                yield f"model.xml/site/{site.name}", "should say pos and size; RoboCasa reads them from the element"


def _geoms(root: etree._Element, asset: Asset, needs: Requirements) -> Iterator[Problem]:
    """Named colliders are geoms that touch; names of contacts and handles are looked up as geoms."""
    groups = {g.get("name", ""): g.get("group") for g in root.iter("geom")}
    for rule in needs.colliders:
        for name in _colliders(asset, rule):
            if groups.get(name) != TOUCHED:
                yield f"model.xml/geom/{name}", f"should be a geom of group {TOUCHED}, which is touched"


def _colliders(asset: Asset, rule: ShapeRule) -> list[str]:
    return [c.name for k in asset.links for c in k.colliders if rule.matches(c.name)]


def _regions(root: etree._Element, body: etree._Element, asset: Asset) -> Iterator[Problem]:
    geoms = {g.get("name") for g in root.iter("geom")}
    for region in asset.regions:
        if f"reg_{region.name}" not in geoms:
            yield f"model.xml/geom/reg_{region.name}", "is not there: v1.0 reads regions from geoms"
    if any(region.name == "main" for region in asset.regions):
        sites = {s.get("name") for s in body.findall("site")}
        missing = [f"ext_{end}" for end in CORNERS if f"ext_{end}" not in sites]
        if missing:
            yield f"model.xml/site/{missing[0]}", "is not on object: v0.2 reads the outer size from sites"
