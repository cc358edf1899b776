"""Mesh -> Mesh prim, and the visuals of a link."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdGeom, UsdShade, Vt

from casa_assets.export.usd import label, number
from casa_assets.export.usd.material import MaterialPrims
from casa_assets.model.asset.asset import Link
from casa_assets.model.asset.mesh import Mesh

GROUP = 1  # MuJoCo's group for what is seen, as in model.xml


def define_all(stage: Usd.Stage, body: Sdf.Path, link: Link, looks: MaterialPrims) -> None:
    """Visuals of a link below `<body>/visual`."""
    if not link.visuals:
        return
    scope = UsdGeom.Scope.Define(stage, body.AppendChild("visual")).GetPath()
    for item in link.visuals:
        prim = define_mesh(stage, scope.AppendChild(item.name), item.mesh)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(looks.surfaces[item.material])
        if item.label is not None:
            label.attach(prim, label.PART, [item.label])
        prim.AddAppliedSchema("MjcImageableAPI")
        number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, GROUP)
        # MuJoCo refuses a mesh without volume unless it is told to take it for a shell; the mass is the body's.
        prim.AddAppliedSchema("NewtonMassAPI")
        number.author(prim, "newton:massModel", Sdf.ValueTypeNames.Token, "shell")


def define_mesh(stage: Usd.Stage, path: Sdf.Path, mesh: Mesh) -> Usd.Prim:
    """Triangles as they are: no subdivision, normals per vertex where the mesh has them, else per face."""
    geom = UsdGeom.Mesh.Define(stage, path)
    geom.CreatePointsAttr(number.points(mesh.vertices))
    geom.CreateFaceVertexCountsAttr(Vt.IntArray(len(mesh.faces), 3))
    geom.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(mesh.faces.ravel(), dtype=np.int32)))
    geom.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    geom.CreateExtentAttr(number.extent(mesh.bounds))
    if mesh.normals is not None:
        geom.CreateNormalsAttr(number.points(mesh.normals))
        geom.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    else:
        geom.CreateNormalsAttr(number.points(face_normals(mesh)))
        geom.SetNormalsInterpolation(UsdGeom.Tokens.uniform)
    if mesh.uv is not None:
        st = UsdGeom.PrimvarsAPI(geom).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex)
        st.Set(number.coordinates(mesh.uv))
    return geom.GetPrim()


def face_normals(mesh: Mesh) -> npt.NDArray[np.float64]:
    """(F, 3) unit normals; z where a face has no area, so that every normal has length one."""
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt((cross * cross).sum(axis=1, keepdims=True))
    flat = length[:, 0] == 0
    normals: npt.NDArray[np.float64] = cross / np.where(length == 0, 1.0, length)
    normals[flat] = (0.0, 0.0, 1.0)
    return normals
