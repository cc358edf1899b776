"""USD stage -> what programs read by name: words, places, named poses. Read with OpenUSD alone."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Literal

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdSemantics

from casa_assets.checks.package.facts import OUTER, PlaceFacts, PoseFacts, ProgramTexts, StateFacts
from casa_assets.checks.readers.mujoco_facts import ROOT_BODY, four, own_name, pose_facts, short_name, three
from casa_assets.checks.readers.rotations import quaternions_of
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

SITE = "MjcSiteAPI"
VARIANTS = "pose"


def words(stage: Usd.Stage) -> ProgramTexts:
    """Classes and labels, states, grips, contract and behaviour."""
    return words_below(stage.GetDefaultPrim())


def words_below(root: Usd.Prim) -> ProgramTexts:
    """Classes and labels, states, grips, contract and behaviour of one asset of many."""
    prims = list(Usd.PrimRange(root))
    joints = [prim for prim in prims if prim.IsA(UsdPhysics.Joint)]
    names = {prim.GetName() for prim in prims}
    behavior = _text(root, "casa:behavior")
    return ProgramTexts(
        classes=_labels(root, "class"),
        portion=" ".join(_labels(root, "portion")),
        labels=tuple(
            sorted((p.GetName(), label) for p in prims if p.IsA(UsdGeom.Gprim) for label in _labels(p, "part"))
        ),
        grips=_links(joints, "casa:grip", names),
        behind=_links(joints, "casa:behind", names),
        states=tuple(sorted((s for j in joints for s in _states(j)), key=lambda state: state.name)),
        contract=_text(root, "casa:contract"),
        behavior=hashlib.sha256(behavior.encode()).hexdigest() if behavior else "",
    )


def places(stage: Usd.Stage) -> tuple[PlaceFacts, ...]:
    """Prims that are sites, sorted by name; those that have a colour of their own are no regions.

    Raises:
        ValueError: one is neither sphere, cube nor cylinder about z.
    """
    cache = UsdGeom.XformCache()
    # As written: GetAppliedSchemas knows the schemas of MuJoCo only where its reader of USD is installed.
    sites = [prim for prim in stage.Traverse() if SITE in prim.GetPrimTypeInfo().GetAppliedAPISchemas()]
    matrices = [_in_body(prim, cache) for prim in sites]
    found = [_place(*site) for site in zip(sites, matrices, *rigid_all(matrices), strict=True)]
    return tuple(sorted((place for place in found if own_name(place.name) != OUTER), key=lambda place: place.name))


def poses(stage: Usd.Stage, scene: bool = False) -> tuple[PoseFacts, ...]:
    """Poses of the bodies in each variant of `pose`, sorted by name. The stage is left as it was.

    Args:
        stage: with the variants on its default prim.
        scene: whether it holds many placements; then poses are world_from_body, else root_from_body.
    """
    variants = stage.GetDefaultPrim().GetVariantSet(VARIANTS)
    bodies = sorted(p.GetPath() for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI))
    names, found = [short_name(str(path)) for path in bodies], []
    # In the session layer, which is no part of the file.
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for name in sorted(variants.GetVariantNames()):
            # What is selected already is not selected again: each selection composes the whole stage anew.
            if variants.GetVariantSelection() != name:
                variants.SetVariantSelection(name)
            cache = UsdGeom.XformCache()
            matrices = [cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path)) for path in bodies]
            world_from = dict(zip(names, zip(*rigid_all(matrices), strict=True), strict=True))
            found.append(pose_facts(name, world_from, None if scene else ROOT_BODY))
        variants.ClearVariantSelection()
    return tuple(found)


def _labels(prim: Usd.Prim, taxonomy: str) -> tuple[str, ...]:
    if not prim.HasAPI(UsdSemantics.LabelsAPI, taxonomy):
        return ()
    return tuple(UsdSemantics.LabelsAPI(prim, taxonomy).GetLabelsAttr().Get() or ())


def _text(prim: Usd.Prim, name: str) -> str:
    return str(prim.GetAttribute(name).Get() or "")


def _links(joints: list[Usd.Prim], name: str, known: set[str]) -> tuple[tuple[str, str], ...]:
    """(joint, name of a prim that there is) of the joints that have the attribute."""
    found = [(joint.GetName(), _text(joint, name)) for joint in joints]
    return tuple(sorted((joint, target) for joint, target in found if target in known))


def _states(joint: Usd.Prim) -> list[StateFacts]:
    named = joint.GetCustomDataByKey("states") or {}
    return [
        StateFacts(name=name, joint=joint.GetName(), value=said["value"], interval=(said["from"], said["to"]))
        for name, said in named.items()
    ]


def _in_body(prim: Usd.Prim, cache: UsdGeom.XformCache) -> Gf.Matrix4d:
    """body_from_place with its scale; places lie two levels below their body."""
    body = prim.GetParent().GetParent()
    return cache.GetLocalToWorldTransform(prim) * cache.GetLocalToWorldTransform(body).GetInverse()


def _place(prim: Usd.Prim, matrix: Gf.Matrix4d, position: Vec3, quaternion: Vec4) -> PlaceFacts:
    scale = [matrix.GetRow3(i).GetLength() for i in range(3)]
    kind, own = _volume(prim)
    x, y, z = (float(s * n) for s, n in zip(scale, own, strict=True))
    return PlaceFacts(
        name=short_name(str(prim.GetPath())),
        body=short_name(str(prim.GetParent().GetParent().GetPath())),
        kind=kind,
        position=position,
        quaternion=quaternion,
        size=(x, y, z),
        color=_color(UsdGeom.Gprim(prim)),
    )


def _volume(prim: Usd.Prim) -> tuple[Literal["sphere", "box", "cylinder"], Vec3]:
    """Kind and full size of a gprim before any scale."""
    if prim.IsA(UsdGeom.Cube):
        size = float(UsdGeom.Cube(prim).GetSizeAttr().Get())
        return "box", (size, size, size)
    if prim.IsA(UsdGeom.Sphere):
        size = 2 * float(UsdGeom.Sphere(prim).GetRadiusAttr().Get())
        return "sphere", (size, size, size)
    rod = UsdGeom.Cylinder(prim)
    if rod and rod.GetAxisAttr().Get() == UsdGeom.Tokens.z:
        across = 2 * float(rod.GetRadiusAttr().Get())
        return "cylinder", (across, across, float(rod.GetHeightAttr().Get()))
    raise ValueError(f"place {prim.GetName()!r} is neither sphere, cube nor cylinder about z")


def _color(gprim: UsdGeom.Gprim) -> Vec4 | None:
    """Linear RGBA, None where it has no colour of its own."""
    colors, alphas = gprim.GetDisplayColorAttr().Get(), gprim.GetDisplayOpacityAttr().Get()
    if not colors or not alphas:
        return None
    red, green, blue = (float(n) for n in colors[0])
    return red, green, blue, float(alphas[0])


def rigid(matrix: Gf.Matrix4d) -> Pose:
    """Pose of a matrix of row vectors, without its scale."""
    (position,), (quaternion,) = rigid_all([matrix])
    return Pose(position=position, quaternion=quaternion)


def rigid_all(matrices: Sequence[Gf.Matrix4d]) -> tuple[list[Vec3], list[Vec4]]:
    """Positions and quaternions of matrices of row vectors, without their scale."""
    rows = np.array([np.array(matrix) for matrix in matrices]).reshape(-1, 4, 4)
    axes = rows[:, :3, :3] / np.linalg.norm(rows[:, :3, :3], axis=2, keepdims=True)
    positions, quaternions = rows[:, 3, :3] + 0.0, quaternions_of(axes.transpose(0, 2, 1))
    return [three(row) for row in positions.tolist()], [four(row) for row in quaternions.tolist()]
