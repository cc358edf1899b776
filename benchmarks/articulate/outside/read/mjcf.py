"""Read an MJCF model through MuJoCo: bodies, their visible geoms and joints."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from benchmarks.articulate.outside.model import (
    Joint,
    Link,
    Model,
    Unreadable,
    closed_value,
    moved,
    primitive,
    transform,
)
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Sphere

# Geoms of this group and above are hidden by viewers.
HIDDEN_GROUP = 3
# Name of the body that pieces of scenes are put into.
WHOLE = "whole"
_KINDS = {mujoco.mjtJoint.mjJNT_HINGE: "revolute", mujoco.mjtJoint.mjJNT_SLIDE: "prismatic"}


def read(path: Path, root: Path, values: Mapping[str, float], link: str = "", complete: bool = True) -> Model:
    """Read an MJCF file; arguments and errors as of `urdf.read`.

    Args:
        link: name of the body that is wanted. complete: refuse it if a mesh of it is missing.
    """
    del root
    model = _compiled(path, link, complete)
    data = mujoco.MjData(model)
    data.qpos[:] = 0.0
    closed: dict[int, float] = {}
    for j in range(model.njnt):
        if int(model.jnt_type[j]) in (int(k) for k in _KINDS):
            low, high = model.jnt_range[j] if model.jnt_limited[j] else (-np.inf, np.inf)
            closed[j] = closed_value(low, high, values.get(model.joint(j).name))
            data.qpos[model.jnt_qposadr[j]] = closed[j]
        else:
            at = model.jnt_qposadr[j]
            data.qpos[at : at + 7] = model.qpos0[at : at + 7]
    mujoco.mj_kinematics(model, data)
    names = [model.body(b).name or f"body_{b}" for b in range(model.nbody)]
    links: dict[str, Link] = {}
    shown = _shown(model)
    for b in range(model.nbody):
        meshes = [_triangles(model, data, g) for g in range(model.ngeom) if model.geom_bodyid[g] == b and shown[g]]
        parent = "" if b == 0 else names[model.body_parentid[b]]
        links[names[b]] = Link(names[b], parent, _joint(model, data, b, closed), [m for m in meshes if len(m)])
    return Model(links)


def _compiled(path: Path, link: str, complete: bool) -> mujoco.MjModel:
    """Return the model of a file without looks and motors; arguments and errors as of `read`."""
    # Inertias are of no use here, and some files state them in two ways, which MuJoCo refuses.
    plain = path.with_name(f"{path.stem}.{os.getpid()}.xml")
    text = re.sub(r"<inertial\b[^>]*/>", "", path.read_text(encoding="utf-8", errors="replace"))
    if "<mujocoinclude" in text:  # a piece of a scene
        inside = re.sub(r"</?mujocoinclude[^>]*>", "", text)
        text = f'<mujoco><compiler angle="radian"/><worldbody><body name="{WHOLE}">{inside}</body></worldbody></mujoco>'
    plain.write_text(text, encoding="utf-8")
    try:
        spec = mujoco.MjSpec.from_file(str(plain))
        absent = {m.name for m in spec.meshes if not (path.parent / spec.meshdir / m.file).is_file()}
        for geom in spec.geoms:
            geom.material = ""
            if geom.meshname in absent:
                if complete and link in ("", *_names_up(geom.parent)):
                    raise Unreadable(f"the mesh '{geom.meshname}' is missing")
                spec.delete(geom)
        for mesh in [m for m in spec.meshes if m.name in absent]:
            spec.delete(mesh)
        for named in (*spec.materials, *spec.textures, *spec.keys, *spec.sensors, *spec.actuators):
            spec.delete(named)
        for mesh in spec.meshes:
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
        spec.compiler.boundmass, spec.compiler.boundinertia = 1e-3, 1e-6
        spec.compiler.balanceinertia = True
        return spec.compile()
    except (ValueError, RuntimeError) as error:
        raise Unreadable(f"MuJoCo: {str(error).splitlines()[0]}") from error
    finally:
        plain.unlink()


def _names_up(body: mujoco.MjsBody) -> list[str]:
    """Return the names of a body and of all that carry it."""
    names = []
    while body is not None and body.name != "world":
        names.append(body.name)
        body = body.parent
    return names


def _shown(model: mujoco.MjModel) -> list[bool]:
    """Return which geoms a person sees: those that nothing touches, where a body has some, else those not hidden."""
    ghost = [not (model.geom_contype[g] or model.geom_conaffinity[g]) for g in range(model.ngeom)]
    group = [int(model.geom_group[g]) for g in range(model.ngeom)]
    faint = [float(model.geom_rgba[g][3]) < 0.05 for g in range(model.ngeom)]
    out = []
    for g in range(model.ngeom):
        mine = [h for h in range(model.ngeom) if model.geom_bodyid[h] == model.geom_bodyid[g]]
        # A body with meshes to look at and shapes to touch shows the meshes.
        has_looks = any(ghost[h] and not faint[h] and group[h] < HIDDEN_GROUP for h in mine)
        touched_too = any(not ghost[h] for h in mine) and has_looks
        out.append(group[g] < HIDDEN_GROUP and not faint[g] and (ghost[g] or not touched_too))
    return out


def _joint(model: mujoco.MjModel, data: mujoco.MjData, body: int, closed: Mapping[int, float]) -> Joint | None:
    """Return the joint of a body that reaches farthest; None if it is fixed or free."""
    best = None
    for j in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
        kind = _KINDS.get(mujoco.mjtJoint(int(model.jnt_type[j])))
        if kind is None:
            continue
        low, high = (float(v) for v in model.jnt_range[j])
        if not model.jnt_limited[j]:
            kind = "continuous" if kind == "revolute" else kind
            low, high = (0.0, 0.3) if kind == "prismatic" else (-np.pi, np.pi)
        reach = (low - closed[j], high - closed[j])
        name = model.joint(j).name or f"joint_{j}"
        joint = Joint(name, kind, data.xaxis[j].copy(), data.xanchor[j].copy(), reach)
        if not joint.is_fixed and (best is None or np.ptp(joint.range) > np.ptp(best.range)):
            best = joint
    return best


def _triangles(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Floats:
    """Return the triangles of a geom at its place; none for planes and fields of heights."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    pose = transform(data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3))
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        points = model.mesh_vert[first : first + count].astype(np.float64)
        return moved(points[model.mesh_face[start : start + faces]], pose)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        found = primitive(Box(size=(2 * size[0], 2 * size[1], 2 * size[2])))
    elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        found = primitive(Sphere(radius=size[0]))
    elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        found = primitive(Cylinder(radius=size[0], height=2 * size[1]))
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        found = primitive(Capsule(radius=size[0], height=2 * size[1]))
    elif kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        found = primitive(Sphere(radius=1.0)) * size
    else:
        return np.zeros((0, 3, 3))
    return moved(found, pose)
