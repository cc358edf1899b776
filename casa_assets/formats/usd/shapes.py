"""Visuals, colliders, sites, regions and materials -> prims and attributes of USD."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from casa_assets.formats.usd import joint, number
from casa_assets.formats.values import VIEWER_GROUPS, contact_dimensions, site_group
from casa_assets.mesh import surface
from casa_assets.model.asset.asset import Asset, Collider, Link, Region, Site
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.asset.parts import MAX_HULL_VERTICES, Box, Capsule, Cylinder, Hull, Mesh, Shape, Sphere
from casa_assets.model.record import Vec4

# Material -------------------------------------------------------------------------------------------------------------
# Material -> UsdPreviewSurface; substance -> physics material.

# Names of scopes; camelCase, which no link id is.
SURFACES = "visualMaterials"
CONTACTS = "physicsMaterials"
GREY = (0.5, 0.5, 0.5)
# Ref: PNG (Third Edition) 11.2.1: offset of the colour type, and the types with alpha.
PNG_COLOR_TYPE = 25
PNG_WITH_ALPHA = (4, 6)


@dataclass(frozen=True)
class MaterialPrims:
    """Material prims: `surfaces` by material id, `contacts` by substance id."""

    surfaces: dict[str, UsdShade.Material]
    contacts: dict[str, UsdShade.Material]


def define_materials(stage: Usd.Stage, root: Sdf.Path, asset: Asset, textures: str) -> MaterialPrims:
    """Define every material and substance below the asset's root; `textures`: path from the layer to the pictures."""
    surfaces: dict[str, UsdShade.Material] = {}
    if asset.materials:
        scope = UsdGeom.Scope.Define(stage, root.AppendChild(SURFACES)).GetPath()
        for material in asset.materials:
            surfaces[material.id] = _surface(stage, scope.AppendChild(material.id), material, textures)
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(CONTACTS)).GetPath()
    contacts = {s.id: _contact(stage, scope.AppendChild(s.id), s) for s in asset.substances}
    return MaterialPrims(surfaces, contacts)


def _contact(stage: Usd.Stage, path: Sdf.Path, substance: Substance) -> UsdShade.Material:
    """Friction and density. No restitution: MuJoCo has none and warns about it."""
    material = UsdShade.Material.Define(stage, path)
    prim = material.GetPrim()
    physics = UsdPhysics.MaterialAPI.Apply(prim)
    physics.CreateStaticFrictionAttr(substance.static_friction)
    physics.CreateDynamicFrictionAttr(substance.dynamic_friction)
    physics.CreateDensityAttr(substance.density)
    torsional, rolling = substance.torsional_friction, substance.rolling_friction
    values = {"newton:torsionalFriction": torsional, "newton:rollingFriction": rolling}
    number.apply(prim, "NewtonMaterialAPI", values)
    # MuJoCo reads the all-purpose material of a collider as its appearance, and warns where it has no surface.
    shader = _shader(stage, path.AppendChild("surface"), "UsdPreviewSurface")
    _set(shader, diffuseColor=Gf.Vec3f(*GREY), metallic=substance.metallic, roughness=substance.roughness)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    joint.attach_label(prim, "material", [substance.id])
    return material


def _surface(stage: Usd.Stage, path: Sdf.Path, material: Material, textures: str) -> UsdShade.Material:
    prim = UsdShade.Material.Define(stage, path)
    shader = _shader(stage, path.AppendChild("surface"), "UsdPreviewSurface")
    prim.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    if material.textures:
        reader = _shader(stage, path.AppendChild("st"), "UsdPrimvarReader_float2")
        _set(reader, varname="st")
        reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    _set_inputs(shader, material, partial(_picture, stage, path, textures))
    joint.attach_label(prim.GetPrim(), "material", [material.substance])
    return prim


def _set_inputs(shader: UsdShade.Shader, material: Material, picture: Callable[..., UsdShade.Shader]) -> None:
    """Inputs of a UsdPreviewSurface, in the order in which a layer lists them; `picture`: as `_picture`."""
    alpha, base = material.base_color[3], material.base_color_texture
    if base is None:
        _set(shader, diffuseColor=Gf.Vec3f(*material.base_color[:3]), opacity=alpha)
    else:
        _feed(shader, "diffuseColor", picture("base_color", base, material.base_color), "rgb")
        if base.png[PNG_COLOR_TYPE] in PNG_WITH_ALPHA:
            # A second node: SimReady wants alpha read as raw numbers, and one node has one colour space.
            _feed(shader, "opacity", picture("opacity", base, (1, 1, 1, alpha), "raw"), "a")
        else:
            _set(shader, opacity=alpha)
    metallic, roughness = material.metallic, material.roughness
    if material.metallic_roughness_texture is None:
        _set(shader, metallic=metallic, roughness=roughness)
    else:
        node = picture("metallic_roughness", material.metallic_roughness_texture, (1, roughness, metallic, 1))
        _feed(shader, "roughness", node, "g")
        _feed(shader, "metallic", node, "b")
    if material.normal_texture is not None:
        node = picture("normal", material.normal_texture, (2, 2, 2, 1))
        # 0..1 -> -1..1, as UsdPreviewSurface wants of an 8 bit map.
        _set(node, bias=Gf.Vec4f(-1, -1, -1, 0))
        _feed(shader, "normal", node, "rgb")
    if material.glow:
        # A share of the base colour; if that is a picture (a display), of the picture.
        glow = [material.glow * c for c in material.base_color[:3]]
        if base is None:
            _set(shader, emissiveColor=Gf.Vec3f(*glow))
        else:
            node = picture("glow", base)
            _set(node, scale=Gf.Vec4f(*glow, 1))
            _feed(shader, "emissiveColor", node, "rgb")


def _picture(
    stage: Usd.Stage,
    path: Sdf.Path,
    textures: str,
    name: str,
    texture: Texture,
    scale: Vec4 = (1, 1, 1, 1),
    color_space: str = "",
) -> UsdShade.Shader:
    """A UsdUVTexture node below a material.

    Args:
        path: of the material. textures: path from the layer to the folder of the pictures. name: of the node.
        scale: factors of the channels. color_space: other than that of the texture.
    """
    node = _shader(stage, path.AppendChild(name), "UsdUVTexture")
    space = color_space or ("sRGB" if texture.color_space is ColorSpace.SRGB else "raw")
    file = f"{textures}/{texture.file_name}"
    _set(node, file=file, sourceColorSpace=space, wrapS="repeat", wrapT="repeat")
    _feed(node, "st", UsdShade.Shader(stage.GetPrimAtPath(path.AppendChild("st"))), "result")
    if scale != (1, 1, 1, 1):
        _set(node, scale=Gf.Vec4f(*scale))
    return node


def _shader(stage: Usd.Stage, path: Sdf.Path, identifier: str) -> UsdShade.Shader:
    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(identifier)
    return shader


_COLOR, _FLOAT, _TOKEN = Sdf.ValueTypeNames.Color3f, Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Token
_INPUTS = {
    **dict.fromkeys(("diffuseColor", "emissiveColor"), _COLOR),
    **dict.fromkeys(("metallic", "roughness", "opacity"), _FLOAT),
    "normal": Sdf.ValueTypeNames.Normal3f,
    "file": Sdf.ValueTypeNames.Asset,
    **dict.fromkeys(("sourceColorSpace", "wrapS", "wrapT"), _TOKEN),
    **dict.fromkeys(("scale", "bias"), Sdf.ValueTypeNames.Float4),
    "st": Sdf.ValueTypeNames.Float2,
    "varname": Sdf.ValueTypeNames.String,
}
_OUTPUTS = {
    "rgb": Sdf.ValueTypeNames.Float3,
    "result": Sdf.ValueTypeNames.Float2,
    **dict.fromkeys(("g", "b", "a"), _FLOAT),
}


def _set(shader: UsdShade.Shader, **values: object) -> None:
    for name, value in values.items():
        shader.CreateInput(name, _INPUTS[name]).Set(value)


def _feed(target: UsdShade.Shader, name: str, source: UsdShade.Shader, output: str) -> None:
    """Connect an input to the output of another node."""
    source.CreateOutput(output, _OUTPUTS[output])
    target.CreateInput(name, _INPUTS[name]).ConnectToSource(source.ConnectableAPI(), output)


# Visual ---------------------------------------------------------------------------------------------------------------
# Mesh -> Mesh prim, and the visuals of a link.


def define_visuals(stage: Usd.Stage, body: Sdf.Path, link: Link, materials: MaterialPrims) -> None:
    """Visuals of a link below `<body>/visual`."""
    if not link.visuals:
        return
    scope = UsdGeom.Scope.Define(stage, body.AppendChild("visual")).GetPath()
    for visual in link.visuals:
        prim = define_mesh(stage, scope.AppendChild(visual.name), visual.mesh)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials.surfaces[visual.material])
        if visual.label is not None:
            joint.attach_label(prim, joint.PART, [visual.label])
        number.apply(prim, "MjcImageableAPI", {"mjc:group": VIEWER_GROUPS.visuals})
        # MuJoCo refuses a mesh without volume unless it is declared a shell; the body has the mass.
        number.apply(prim, "NewtonMassAPI", {"newton:massModel": "shell"})


def define_mesh(stage: Usd.Stage, path: Sdf.Path, mesh: Mesh) -> Usd.Prim:
    """Triangles without subdivision; normals per vertex if the mesh has them, else per face."""
    geom = UsdGeom.Mesh.Define(stage, path)
    geom.CreatePointsAttr(number.points(mesh.vertices))
    geom.CreateFaceVertexCountsAttr(Vt.IntArray(len(mesh.faces), 3))
    geom.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(mesh.faces.ravel(), dtype=np.int32)))
    geom.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    geom.CreateExtentAttr(number.points(mesh.bounds))
    normals = mesh.normals if mesh.normals is not None else face_normals(mesh)
    geom.CreateNormalsAttr(number.points(normals))
    geom.SetNormalsInterpolation(UsdGeom.Tokens.vertex if mesh.normals is not None else UsdGeom.Tokens.uniform)
    if mesh.uv is not None:
        st = UsdGeom.PrimvarsAPI(geom).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex)
        st.Set(number.coordinates(mesh.uv))
    return geom.GetPrim()


def face_normals(mesh: Mesh) -> npt.NDArray[np.float64]:
    """(F, 3) unit normals; z for faces without area, so that every normal has length one."""
    normals, areas = surface.face_normals(mesh.vertices, mesh.faces.astype(np.int64))
    normals[areas == 0] = (0.0, 0.0, 1.0)
    return normals


# Collider -------------------------------------------------------------------------------------------------------------
# Collider -> invisible gprim with a collision API.


def define_colliders(stage: Usd.Stage, body: Sdf.Path, link: Link, materials: MaterialPrims) -> None:
    """Colliders of a link below `<body>/collision`."""
    if not link.colliders:
        return
    scope = UsdGeom.Scope.Define(stage, body.AppendChild("collision"))
    # Guides are not rendered, but SimReady counts a collider with the same mesh as a visual (a box, a fixture) as a
    # duplicate unless it is invisible.
    UsdGeom.Imageable(scope).CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    for collider in link.colliders:
        prim = define_shape(stage, scope.GetPath().AppendChild(collider.name), collider.shape)
        _set_collision(prim, collider, materials)


def define_shape(stage: Usd.Stage, path: Sdf.Path, shape: Shape) -> Usd.Prim:
    """Gprim of a shape in its own frame, without xform ops; `place` scales the unit cube of a box."""
    if isinstance(shape, Box):
        # A unit cube under a scale; USD has no other box.
        cube = UsdGeom.Cube.Define(stage, path)
        cube.CreateSizeAttr(1.0)
        cube.CreateExtentAttr(number.points(np.array([[-0.5] * 3, [0.5] * 3])))
        return cube.GetPrim()
    if isinstance(shape, Sphere):
        ball = UsdGeom.Sphere.Define(stage, path)
        ball.CreateRadiusAttr(shape.radius)
        ball.CreateExtentAttr(number.points(np.array([[-shape.radius] * 3, [shape.radius] * 3])))
        return ball.GetPrim()
    if isinstance(shape, Cylinder | Capsule):
        kind = UsdGeom.Cylinder if isinstance(shape, Cylinder) else UsdGeom.Capsule
        cylinder = kind.Define(stage, path)
        cylinder.CreateAxisAttr(UsdGeom.Tokens.z)
        cylinder.CreateRadiusAttr(shape.radius)
        cylinder.CreateHeightAttr(shape.height)
        cap = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, shape.height / 2 + cap])
        cylinder.CreateExtentAttr(number.points(np.array([-half, half])))
        return cylinder.GetPrim()
    return define_mesh(stage, path, shape.mesh)


def _set_collision(prim: Usd.Prim, collider: Collider, materials: MaterialPrims) -> None:
    """Pose, purpose, collision schemas and friction."""
    number.place(prim, collider.pose, collider.shape.size if isinstance(collider.shape, Box) else None)
    UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
    if collider.label is not None:
        joint.attach_label(prim, joint.PART, [collider.label])
    UsdPhysics.CollisionAPI.Apply(prim)
    if prim.IsA(UsdGeom.Mesh):
        hull = isinstance(collider.shape, Hull)
        kind = UsdPhysics.Tokens.convexHull if hull else UsdPhysics.Tokens.none
        UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(kind)
        if hull:
            number.apply(prim, "NewtonMeshCollisionAPI", {"newton:maxHullVertices": MAX_HULL_VERTICES})
    condim = contact_dimensions(collider.shape)
    number.apply(prim, "MjcCollisionAPI", {"mjc:condim": condim, "mjc:group": VIEWER_GROUPS.colliders})
    # Twice: PhysX and Newton read the `physics` binding, MuJoCo only the one for all purposes.
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    material = materials.contacts[collider.substance]
    binding.Bind(material)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")


# Site -----------------------------------------------------------------------------------------------------------------
# Site and region -> guide gprims that physics ignores and MuJoCo reads as sites.


def define_sites(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Sites and regions below `<root>/<link>/sites`."""
    items: tuple[Site | Region, ...] = (*asset.sites, *asset.regions)
    for item in items:
        scope = UsdGeom.Scope.Define(stage, root.AppendChild(item.link).AppendChild("sites")).GetPath()
        if item.size is None:
            shape: Shape = Sphere(radius=item.radius)
        elif item.kind == "box":
            shape = Box(size=item.size)
        else:
            shape = Cylinder(radius=item.size[0] / 2, height=item.size[2])
        prim = define_shape(stage, scope.AppendChild(item.name), shape)
        number.place(prim, item.pose, shape.size if isinstance(shape, Box) else None)
        UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
        prim.AddAppliedSchema("NewtonSiteAPI")
        group = site_group(item) if isinstance(item, Site) else VIEWER_GROUPS.regions
        number.apply(prim, "MjcSiteAPI", {"mjc:group": group})
        if isinstance(item, Site):
            UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(*item.color[:3])])
            UsdGeom.Gprim(prim).CreateDisplayOpacityAttr([item.color[3]])
