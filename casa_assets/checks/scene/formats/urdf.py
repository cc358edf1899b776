"""Find differences between a scene and its URDF files, read back from a folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
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
from casa_assets.checks.readers.facts import four, text, three
from casa_assets.checks.readers.urdf_facts import UrdfAsset
from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record, Vec3, Vec4

FILE, LIST = "scene.urdf", "scene.json"


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
    read = urdf_facts.read(folder / FILE)
    roots = {read.model.body(i).name: i for i in range(1, read.model.nbody) if not read.model.body_parentid[i]}
    fixed = [place for place in scene.placements if scene.asset_of[place.name].base is Base.FIXED]
    yield from (row.problem for row in text("placements", sorted(place.name for place in fixed), sorted(roots)))
    for place in fixed:
        if place.name not in roots:
            continue
        asset, body = scene.asset_of[place.name], roots[place.name]
        aside = urdf_facts.beside(folder / f"{asset.id}.urdf")
        yield from _below(place.name, table_differences(UrdfAsset(read, aside, place.name), asset))
        found = Pose(position=three(read.model.body_pos[body]), quaternion=four(read.model.body_quat[body]))
        yield from _below(place.name, compare(place.pose @ asset.root.pose, found, TOLERANCE, LENGTH_TOLERANCE_M))


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
