"""Find differences between a scene and its URDF files, read back from a folder."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from casa_assets.checks.check import Problem
from casa_assets.checks.package import parity
from casa_assets.checks.package.facts import Difference, numbers, quaternion, text
from casa_assets.checks.package.parity import LENGTH_TOLERANCE_M, TOLERANCE, asset_differences, table_differences
from casa_assets.checks.readers import urdf_facts
from casa_assets.checks.readers.urdf_facts import UrdfLink
from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.kitchen.scene import WORLD, Placement, Scene

FILE, LIST = "scene.urdf", "scene.json"
SEPARATOR = "__"


def scene_differences(folder: Path, scene: Scene) -> list[Problem]:
    """One problem for each cell in which the URDF files of a scene differ from it.

    Args:
        folder: with scene.urdf, scene.json and the files of every asset.
    """
    problems = [
        (f"{asset.id}.urdf/{pointer}", message)
        for asset in scene.assets
        for pointer, message in asset_differences(folder / f"{asset.id}.urdf", asset)
    ]
    try:
        problems += [(f"{FILE}/{pointer}", message) for pointer, message in _tree_differences(folder, scene)]
        problems += [(f"{LIST}/{pointer}", message) for pointer, message in _list_differences(folder, scene)]
    except (OSError, ValueError, KeyError, TypeError) as error:
        problems.append((str(folder.name), f"cannot be read: {' '.join(str(error).split())}"))
    return problems


def _tree_differences(folder: Path, scene: Scene) -> Iterator[Problem]:
    """Differences of the fixed placements, one by one."""
    trees = _by_placement(urdf_facts.links(folder / FILE))
    fixed = [place for place in scene.placements if scene.asset_of[place.name].base is Base.FIXED]
    yield from _problems(text("placements", sorted(place.name for place in fixed), sorted(trees)))
    for place in fixed:
        if place.name not in trees:
            continue
        asset, tree = scene.asset_of[place.name], trees[place.name]
        aside = urdf_facts.beside(folder / f"{asset.id}.urdf")
        for pointer, message in table_differences(tree, folder, aside, asset, place.name + SEPARATOR):
            yield f"{place.name}/{pointer}", message
        root = next(link for link in tree if link.parent == WORLD)
        expected = place.pose @ asset.root.pose
        yield from _problems(
            (
                numbers(f"{place.name}/position", expected.position, root.pose.position),
                quaternion(f"{place.name}/quaternion", expected.quaternion, root.pose.quaternion),
            )
        )


def _by_placement(tree: tuple[UrdfLink, ...]) -> dict[str, tuple[UrdfLink, ...]]:
    """Links of each placement under the names that they have in the asset, the root tied to the world."""
    found: dict[str, list[UrdfLink]] = {}
    for link in tree:
        if link.name != WORLD:
            placement = link.name.split(SEPARATOR)[0]
            names = (_name_in_asset(name, placement) for name in (link.name, link.parent))
            name, parent = names
            found.setdefault(placement, []).append(replace(link, name=name, parent=parent))
    return {placement: tuple(links) for placement, links in found.items()}


def _name_in_asset(name: str, placement: str) -> str:
    return urdf_facts.ROOT if name == placement else name.removeprefix(placement + SEPARATOR)


def _list_differences(folder: Path, scene: Scene) -> Iterator[Problem]:
    """Differences of scene.json: placements, their poses and the positions of their joints."""
    rows = {row["name"]: row for row in json.loads((folder / LIST).read_text(encoding="ascii"))["placements"]}
    yield from _problems(text("placements", [place.name for place in scene.placements], list(rows)))
    for place in scene.placements:
        if place.name in rows:
            yield from _row_differences(place, scene, rows[place.name])


def _row_differences(place: Placement, scene: Scene, row: dict[str, object]) -> Iterator[Problem]:
    asset = scene.asset_of[place.name]
    pose = place.pose @ asset.root.pose
    expected = {"asset": asset.id, "urdf": f"{asset.id}.urdf", "base": asset.base.value, "layer": place.layer.value}
    for name, value in (*expected.items(), ("joints", joint_positions(place.joints))):
        yield from _problems(text(f"{place.name}/{name}", value, row[name]))
    yield from _problems(
        (
            numbers(f"{place.name}/position", pose.position, row["position"]),
            quaternion(f"{place.name}/quaternion", pose.quaternion, row["quaternion"]),
        )
    )


def _problems(rows: Iterator[Difference] | tuple[Difference, ...]) -> Iterator[Problem]:
    for row in rows:
        is_length = row.pointer.endswith("/position")
        if parity.exceeds(row, LENGTH_TOLERANCE_M if is_length else TOLERANCE):
            yield row.pointer, row.message
