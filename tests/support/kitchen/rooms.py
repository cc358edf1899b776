"""Tiny rooms of blocks and cupboards, written and ready to be checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from casa_assets import registry
from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.scene.formats import LIGHT_FILE, SceneFiles
from casa_assets.checks.scene.subject import FILE, SceneSubject
from casa_assets.checks.table import run_scene
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.formats.usd import kitchen as usd
from casa_assets.mesh.inertia import ready_to_simulate
from casa_assets.model.asset.asset import Asset, Base, Collider, Link, Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Shape
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.scene import Layer, Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.asset.asset_parts import CARDBOARD, PROVENANCE, box_inertial, labels
from tests.support.asset.packages import tamper
from tests.support.kitchen.scenes import at, put
from tests.support.mesh.meshes import box_mesh

LIMITS = registry.load().limits
WIDE: Vec3 = (4.0, 4.0, 0.1)
TO_THE_LEFT = (math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5))  # what looks along -y looks along -x


def block(
    name: str,
    size: Vec3,
    base: Base = Base.FIXED,
    kind: str = "wall_cabinet",
    shapes: Sequence[tuple[Shape, Vec3]] = (),
) -> Asset:
    """A box of full `size` on its origin, metres; touched as itself, or as `shapes` at places."""
    middle: Vec3 = (0.0, 0.0, size[2] / 2)
    touched = shapes or [(Box(size=size), middle)]
    return Asset(
        id=f"{name}_0123456789",
        base=base,
        links=(
            Link(
                name="object",
                inertial=box_inertial(1.0, size, middle),
                visuals=(Visual(name="seen", mesh=box_mesh(size, middle), material="paint"),),
                colliders=tuple(
                    Collider(name=f"shape_{i}", shape=form, substance="cardboard", pose=Pose(position=place))
                    for i, (form, place) in enumerate(touched)
                ),
            ),
        ),
        materials=(Material(id="paint", base_color=(0.5, 0.5, 0.5, 1.0)),),
        substances=(CARDBOARD,),
        labels=labels(kind, (kind, "object"), "Q1"),
        provenance=PROVENANCE,
    )


FLOOR = block("floor", WIDE, kind="floor")


def room(*things: tuple[Asset, Pose], floor: Asset = FLOOR, gravity: float = 9.81) -> Scene:
    """Things on a floor whose upper side is z = 0; their placements are called `thing_0`, `thing_1` ..."""
    ground = Placement(name="ground", asset=floor.id, pose=at(0.0, 0.0, -floor.bounds[1, 2].item()), layer=Layer.ROOM)
    assets = {asset.id: asset for asset in (floor, *(asset for asset, _ in things))}
    placements = (Placement(name=f"thing_{i}", asset=asset.id, pose=pose) for i, (asset, pose) in enumerate(things))
    scene = Scene(
        id="room", assets=tuple(assets.values()), placements=(ground, *placements), gravity=(0.0, 0.0, -gravity)
    )
    return ready_to_simulate(scene)


def subject(scene: Scene, folder: Path, *changes: tuple[str, str]) -> SceneSubject:
    own = put(mjcf.write(scene), folder, scene)
    if changes:
        tamper(own / FILE, *changes)
    return SceneSubject(scene, own)


def in_all_forms(scene: Scene, folder: Path) -> SceneFiles:
    own = put(mjcf.write(scene), folder, scene)
    put(usd.write(scene), folder, scene)
    (own / LIGHT_FILE).write_bytes(mjcf.write(light_scene(scene)).entries[FILE])
    return SceneFiles(SceneSubject(scene, own))


def judged(scene: Scene, folder: Path, *changes: tuple[str, str]) -> Report:
    return run_scene(subject(scene, folder, *changes), LIMITS)
