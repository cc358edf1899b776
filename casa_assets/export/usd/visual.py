"""Mesh -> Mesh prim, and the visuals of a link."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Usd, UsdGeom, UsdShade, Vt

from casa_assets.export.mujoco_values import VIEWER_GROUPS
from casa_assets.export.usd import label, number
from casa_assets.export.usd.material import MaterialPrims
from casa_assets.geometry.mesh import measure
from casa_assets.model.asset.asset import Link
from casa_assets.model.asset.mesh import Mesh


def define_all(stage: Usd.Stage, body: Sdf.Path, link: Link, materials: MaterialPrims) -> None:
    """Visuals of a link below `<body>/visual`."""
    if not link.visuals:
        return
    scope = UsdGeom.Scope.Define(stage, body.AppendChild("visual")).GetPath()
    for visual in link.visuals:
        prim = define_mesh(stage, scope.AppendChild(visual.name), visual.mesh)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials.surfaces[visual.material])
        if visual.label is not None:
            label.attach(prim, label.PART, [visual.label])
        prim.AddAppliedSchema("MjcImageableAPI")
        number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, VIEWER_GROUPS.visuals)
        # MuJoCo refuses a mesh without volume unless it is declared a shell; the body has the mass.
        prim.AddAppliedSchema("NewtonMassAPI")
        number.author(prim, "newton:massModel", Sdf.ValueTypeNames.Token, "shell")


def define_mesh(stage: Usd.Stage, path: Sdf.Path, mesh: Mesh) -> Usd.Prim:
    """Triangles without subdivision; normals per vertex if the mesh has them, else per face."""
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
    """(F, 3) unit normals; z for faces without area, so that every normal has length one."""
    normals, areas = measure.face_normals(mesh.vertices, mesh.faces.astype(np.int64))
    normals[areas == 0] = (0.0, 0.0, 1.0)
    return normals
