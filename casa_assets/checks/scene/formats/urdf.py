"""Find differences between a scene and its URDF files, read back from a folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from casa_assets.checks.check import Problem
from casa_assets.checks.package.parity import (
    LENGTH_TOLERANCE_M,
    TOLERANCE,
    asset_differences,
    compare,
    table_differences,
)
from casa_assets.checks.readers import urdf_facts
from casa_assets.checks.readers.facts import text
from casa_assets.checks.readers.urdf_facts import UrdfLink
from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.kitchen.scene import WORLD, Scene
from casa_assets.model.record import Record, Vec3, Vec4

FILE, LIST = "scene.urdf", "scene.json"
SEPARATOR = "__"


def scene_differences(folder: Path, scene: Scene) -> list[Problem]:
    """One problem for each cell in which the URDF files of a scene differ from it.

    Args:
        folder: with scene.urdf, scene.json and the files of every asset.
    """
    problems: list[Problem] = []
    for asset in scene.assets:
        file = f"{asset.id}.urdf"
        problems += _below(file, asset_differences(folder / file, asset))
    try:
        problems += _below(FILE, _tree_differences(folder, scene))
        problems += _below(LIST, _list_differences(folder, scene))
    except (OSError, ValueError, KeyError, TypeError) as error:
        problems.append((str(folder.name), f"cannot be read: {' '.join(str(error).split())}"))
    return problems


def _tree_differences(folder: Path, scene: Scene) -> Iterator[Problem]:
    """Differences of the fixed placements, one by one."""
    trees = _by_placement(urdf_facts.links(folder / FILE))
    fixed = [place for place in scene.placements if scene.asset_of[place.name].base is Base.FIXED]
    yield from (row.problem for row in text("placements", sorted(place.name for place in fixed), sorted(trees)))
    for place in fixed:
        if place.name not in trees:
            continue
        asset, tree = scene.asset_of[place.name], trees[place.name]
        aside = urdf_facts.beside(folder / f"{asset.id}.urdf")
        yield from _below(place.name, table_differences(tree, folder, aside, asset, place.name + SEPARATOR))
        root = next(link for link in tree if link.parent == WORLD)
        pose = place.pose @ asset.root.pose
        yield from _below(place.name, compare(pose, root.pose, TOLERANCE, LENGTH_TOLERANCE_M))


def _by_placement(tree: tuple[UrdfLink, ...]) -> dict[str, tuple[UrdfLink, ...]]:
    """Links of each placement under the names that they have in the asset, the root tied to the world."""
    found: dict[str, list[UrdfLink]] = {}
    for link in tree:
        if link.name != WORLD:
            placement = link.name.split(SEPARATOR)[0]
            name, parent = (_name_in_asset(name, placement) for name in (link.name, link.parent))
            found.setdefault(placement, []).append(replace(link, name=name, parent=parent))
    return {placement: tuple(links) for placement, links in found.items()}


def _name_in_asset(name: str, placement: str) -> str:
    return urdf_facts.ROOT if name == placement else name.removeprefix(placement + SEPARATOR)


class ListedFacts(Record):
    """A row of scene.json."""

    name: str
    asset: str
    urdf: str
    base: str
    layer: str
    joints: dict[str, float]
    position: Vec3
    quaternion: Vec4


def _list_differences(folder: Path, scene: Scene) -> Iterator[Problem]:
    """Differences of scene.json: placements, their poses and the positions of their joints."""
    rows = {row["name"]: row for row in json.loads((folder / LIST).read_text(encoding="ascii"))["placements"]}
    yield from (row.problem for row in text("placements", [place.name for place in scene.placements], list(rows)))
    for place in scene.placements:
        if place.name in rows:
            asset = scene.asset_of[place.name]
            pose = place.pose @ asset.root.pose
            expected = ListedFacts(
                name=place.name,
                asset=asset.id,
                urdf=f"{asset.id}.urdf",
                base=asset.base.value,
                layer=place.layer.value,
                joints=joint_positions(place.joints),
                position=pose.position,
                quaternion=pose.quaternion,
            )
            actual = ListedFacts(**{name: rows[place.name][name] for name in ListedFacts.model_fields})
            yield from _below(place.name, compare(expected, actual, TOLERANCE, LENGTH_TOLERANCE_M))


def _below(at: str, problems: Iterable[Problem]) -> Iterator[Problem]:
    return ((f"{at}/{pointer}", message) for pointer, message in problems)
