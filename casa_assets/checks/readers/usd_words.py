"""USD stage -> what programs read by name: words, places, named poses. Read with OpenUSD alone."""

from __future__ import annotations

import hashlib
from typing import Literal

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdSemantics

from casa_assets.checks.package.facts import OUTER, PlaceFacts, PoseFacts, ProgramTexts, StateFacts
from casa_assets.checks.readers.mujoco_facts import ROOT_BODY, own_name, short_name
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
    found = [_place(prim, cache) for prim in stage.Traverse() if SITE in prim.GetAppliedSchemas()]
    return tuple(sorted((place for place in found if own_name(place.name) != OUTER), key=lambda place: place.name))


def poses(stage: Usd.Stage, scene: bool = False) -> tuple[PoseFacts, ...]:
    """Poses of the bodies in each variant of `pose`, sorted by name. The stage is left as it was.

    Args:
        stage: with the variants on its default prim.
        scene: whether it holds many placements; then poses are world_from_body, else root_from_body.
    """
    variants = stage.GetDefaultPrim().GetVariantSet(VARIANTS)
    bodies = sorted(p.GetPath() for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI))
    found = []
    # In the session layer, which is no part of the file.
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for name in sorted(variants.GetVariantNames()):
            variants.SetVariantSelection(name)
            cache = UsdGeom.XformCache()
            world_from = {
                short_name(str(path)): rigid(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path)))
                for path in bodies
            }
            base = Pose() if scene else world_from[ROOT_BODY].inverse()
            stand = {body: base @ world_from[body] for body in sorted(world_from)}
            found.append(
                PoseFacts(
                    name=name,
                    bodies=tuple(stand),
                    positions=tuple(pose.position for pose in stand.values()),
                    quaternions=tuple(pose.quaternion for pose in stand.values()),
                )
            )
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


def _place(prim: Usd.Prim, cache: UsdGeom.XformCache) -> PlaceFacts:
    body = prim.GetParent().GetParent()
    matrix = cache.GetLocalToWorldTransform(prim) * cache.GetLocalToWorldTransform(body).GetInverse()
    scale = [Gf.Vec3d(*(matrix[i][k] for k in range(3))).GetLength() for i in range(3)]
    pose = rigid(matrix)
    kind, own = _volume(prim)
    x, y, z = (float(s * n) for s, n in zip(scale, own, strict=True))
    return PlaceFacts(
        name=short_name(str(prim.GetPath())),
        body=short_name(str(body.GetPath())),
        kind=kind,
        position=pose.position,
        quaternion=pose.quaternion,
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
    rows = np.array(matrix)
    turned = np.eye(4)
    turned[:3, :3] = (rows[:3, :3] / np.linalg.norm(rows[:3, :3], axis=1, keepdims=True)).T
    turned[:3, 3] = rows[3, :3]
    return Pose.from_matrix(turned)
