"""Attributes by name, materials, visuals, colliders, sites and regions -> prims of USD."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from casa_assets.core.numeric import Floats, decimals
from casa_assets.formats.values import VIEWER_GROUPS, contact_dimensions, site_group
from casa_assets.mesh import surface
from casa_assets.model.asset.asset import Asset, Collider, Link, Region, Site
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.asset.parts import MAX_HULL_VERTICES, Box, Capsule, Cylinder, Hull, Mesh, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec4

# Names of scopes; camelCase, which no link id is.
SURFACES = "visualMaterials"
CONTACTS = "physicsMaterials"
GREY = (0.5, 0.5, 0.5)
PLAIN = (1, 1, 1, 1)
# The taxonomy of the part of an asset that a visual or collider is: handle, door, shelf.
PART = "part"
# Ref: PNG (Third Edition) 11.2.1: offset of the colour type, and the types with alpha.
PNG_COLOR_TYPE = 25
PNG_WITH_ALPHA = (4, 6)

_TYPES = Sdf.ValueTypeNames
# Attributes that this USD build may not have registered, those of schemas (mjc, newton) and our own: declared type,
# whether uniform.
_KINDS: dict[str, tuple[Sdf.ValueTypeName, bool]] = {
    **dict.fromkeys(("newton:armature", "newton:damping", "newton:friction"), (_TYPES.Float, False)),
    **dict.fromkeys(("newton:torsionalFriction", "newton:rollingFriction"), (_TYPES.Float, False)),
    "newton:massModel": (_TYPES.Token, True),
    **dict.fromkeys(("newton:maxHullVertices", "mjc:condim", "mjc:group"), (_TYPES.Int, True)),
    **dict.fromkeys(("mjc:solimplimit", "mjc:solimpfriction"), (_TYPES.DoubleArray, True)),
    **dict.fromkeys(("mjc:stiffness", "mjc:springref", "mjc:margin"), (_TYPES.Double, True)),
    **dict.fromkeys(("casa:contract", "casa:behavior", "casa:grip", "casa:behind"), (_TYPES.String, True)),
    "casa:layer": (_TYPES.Token, True),
}
# Inputs and outputs of shaders.
_INPUTS = {
    **dict.fromkeys(("diffuseColor", "emissiveColor"), _TYPES.Color3f),
    **dict.fromkeys(("metallic", "roughness", "opacity"), _TYPES.Float),
    "normal": _TYPES.Normal3f,
    "file": _TYPES.Asset,
    **dict.fromkeys(("sourceColorSpace", "wrapS", "wrapT"), _TYPES.Token),
    **dict.fromkeys(("scale", "bias"), _TYPES.Float4),
    "st": _TYPES.Float2,
    "varname": _TYPES.String,
}
_OUTPUTS = {"rgb": _TYPES.Float3, "result": _TYPES.Float2, **dict.fromkeys(("g", "b", "a"), _TYPES.Float)}
# Name of a shader -> its type and inputs: values, or the shader and the output of it that they are fed from.
Network = dict[str, tuple[str, dict[str, object]]]


def put(prim: Usd.Prim, values: Mapping[str, object], *schemas: str) -> Usd.Prim:
    """Apply schemas to a prim and set its attributes by their full names; None is left out."""
    for schema in schemas:
        prim.AddAppliedSchema(schema)
    for name, value in values.items():
        if value is None:
            continue
        attribute = prim.GetAttribute(name)
        if name in _KINDS:
            kind, is_uniform = _KINDS[name]
            variability = Sdf.VariabilityUniform if is_uniform else Sdf.VariabilityVarying
            attribute = prim.CreateAttribute(name, kind, name.startswith("casa:"), variability)
        attribute.Set(value)
    return prim


def attach_label(prim: Usd.Prim, taxonomy: str, labels: Sequence[str]) -> None:
    """Set the labels of one taxonomy on a prim."""
    put(prim, {f"semantics:labels:{taxonomy}": list(labels)}, f"SemanticsLabelsAPI:{taxonomy}")


def vec3d(values: Sequence[float]) -> Gf.Vec3d:
    """Three doubles, exact."""
    return Gf.Vec3d(*(float(v) for v in values))


def quatd(quaternion: Vec4) -> Gf.Quatd:
    """(w, x, y, z) -> quaternion, to twelve digits: the last ones differ from processor to processor."""
    return Gf.Quatd(*(decimals(c, 12) for c in quaternion))


def points(array: Floats) -> Vt.Vec3fArray:
    """(N, 3) float64 -> Vec3fArray."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def place(prim: Usd.Prim, pose: Pose, scale: Sequence[float] | None = None) -> None:
    """Write translate, orient and scale of a prim without any, in double precision; the identity is left out.

    `pose`: parent_from_prim. `scale`: factors along the prim's own axes.
    """
    xform = UsdGeom.Xformable(prim)
    if any(pose.position):
        xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(vec3d(pose.position))
    if any(pose.quaternion[1:]):
        xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(quatd(pose.quaternion))
    if scale is not None:
        xform.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(vec3d(scale))


# Material -------------------------------------------------------------------------------------------------------------


def define_materials(stage: Usd.Stage, root: Sdf.Path, asset: Asset, textures: str) -> None:
    """Define every material and substance below the asset's root; `textures`: path from the layer to the pictures."""
    if asset.materials:
        scope = UsdGeom.Scope.Define(stage, root.AppendChild(SURFACES)).GetPath()
        for look in asset.materials:
            material = UsdShade.Material.Define(stage, scope.AppendChild(look.id))
            _define_network(material, _network(look, textures))
            attach_label(material.GetPrim(), "material", [look.substance])
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(CONTACTS)).GetPath()
    for substance in asset.substances:
        _define_contact(UsdShade.Material.Define(stage, scope.AppendChild(substance.id)), substance)


def _bind(prim: Usd.Prim, root: Sdf.Path, scope: str, name: str, purpose: str = "") -> None:
    """Bind a prim to a material below the asset's root."""
    material = UsdShade.Material(prim.GetStage().GetPrimAtPath(root.AppendChild(scope).AppendChild(name)))
    strength = (UsdShade.Tokens.weakerThanDescendants, purpose) if purpose else ()
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, *strength)


def _define_contact(material: UsdShade.Material, substance: Substance) -> None:
    """Friction and density. No restitution: MuJoCo has none and warns about it."""
    values = {
        "physics:staticFriction": substance.static_friction,
        "physics:dynamicFriction": substance.dynamic_friction,
        "physics:density": substance.density,
        "newton:torsionalFriction": substance.torsional_friction,
        "newton:rollingFriction": substance.rolling_friction,
    }
    put(material.GetPrim(), values, "PhysicsMaterialAPI", "NewtonMaterialAPI")
    # MuJoCo reads the all-purpose material of a collider as its appearance, and warns where it has no surface.
    look = {"diffuseColor": GREY, "metallic": substance.metallic, "roughness": substance.roughness}
    _define_network(material, {"surface": ("UsdPreviewSurface", look)})
    attach_label(material.GetPrim(), "material", [substance.id])


def _define_network(material: UsdShade.Material, network: Network) -> None:
    """Define shaders below a material, whose surface is the one of that name."""
    stage, path = material.GetPrim().GetStage(), material.GetPath()
    shaders = {name: UsdShade.Shader.Define(stage, path.AppendChild(name)) for name in network}
    material.CreateSurfaceOutput().ConnectToSource(shaders["surface"].ConnectableAPI(), "surface")
    for name, (kind, inputs) in network.items():
        shaders[name].CreateIdAttr(kind)
        for entry, value in inputs.items():
            port = shaders[name].CreateInput(entry, _INPUTS[entry])
            if isinstance(value, tuple) and value[0] in shaders:
                source, output = value
                shaders[source].CreateOutput(output, _OUTPUTS[output])
                port.ConnectToSource(shaders[source].ConnectableAPI(), output)
            else:
                port.Set(value)


def _network(material: Material, textures: str) -> Network:
    """Shaders of a material; `textures`: path from the layer to the folder of the pictures."""
    alpha, base = material.base_color[3], material.base_color_texture
    inputs: dict[str, object] = {"diffuseColor": material.base_color[:3], "opacity": alpha}
    network: Network = {"surface": ("UsdPreviewSurface", inputs)}
    if material.textures:
        network["st"] = ("UsdPrimvarReader_float2", {"varname": "st"})

    def picture(name: str, texture: Texture, factors: Vec4 = PLAIN, space: str = "", **others: object) -> None:
        """`factors`: of the channels. `space`: colour space, if not that of the texture."""
        space = space or ("sRGB" if texture.color_space is ColorSpace.SRGB else "raw")
        values = {"file": f"{textures}/{texture.file_name}", "sourceColorSpace": space, "wrapS": "repeat"}
        scaled = {} if factors == PLAIN else {"scale": factors}
        network[name] = ("UsdUVTexture", {**values, "wrapT": "repeat", "st": ("st", "result"), **scaled, **others})

    if base is not None:
        picture("base_color", base, material.base_color)
        inputs["diffuseColor"] = "base_color", "rgb"
        if base.png[PNG_COLOR_TYPE] in PNG_WITH_ALPHA:
            # A second node: SimReady wants alpha read as raw numbers, and one node has one colour space.
            picture("opacity", base, (1, 1, 1, alpha), "raw")
            inputs["opacity"] = "opacity", "a"
    inputs |= {"metallic": material.metallic, "roughness": material.roughness}
    if material.metallic_roughness_texture is not None:
        factors = (1, material.roughness, material.metallic, 1)
        picture("metallic_roughness", material.metallic_roughness_texture, factors)
        inputs |= {"roughness": ("metallic_roughness", "g"), "metallic": ("metallic_roughness", "b")}
    if material.normal_texture is not None:
        # 0..1 -> -1..1, as UsdPreviewSurface wants of an 8 bit map.
        picture("normal", material.normal_texture, (2, 2, 2, 1), bias=(-1, -1, -1, 0))
        inputs["normal"] = "normal", "rgb"
    if material.glow:
        # A share of the base colour; if that is a picture (a display), of the picture.
        red, green, blue = (material.glow * c for c in material.base_color[:3])
        inputs["emissiveColor"] = (red, green, blue) if base is None else ("glow", "rgb")
        if base is not None:
            picture("glow", base, scale=(red, green, blue, 1))
    return network


# Shapes ---------------------------------------------------------------------------------------------------------------
# Visuals and colliders of a link: a collider is an invisible gprim with a collision API.


def define_visuals(stage: Usd.Stage, root: Sdf.Path, link: Link) -> None:
    """Visuals of a link below `<root>/<link>/visual`."""
    if not link.visuals:
        return
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(link.name).AppendChild("visual")).GetPath()
    for visual in link.visuals:
        prim = _define_mesh(stage, scope.AppendChild(visual.name), visual.mesh)
        _bind(prim, root, SURFACES, visual.material)
        if visual.label is not None:
            attach_label(prim, PART, [visual.label])
        # MuJoCo refuses a mesh without volume unless it is declared a shell; the body has the mass.
        values = {"mjc:group": VIEWER_GROUPS.visuals, "newton:massModel": "shell"}
        put(prim, values, "MjcImageableAPI", "NewtonMassAPI")


def _define_mesh(stage: Usd.Stage, path: Sdf.Path, mesh: Mesh) -> Usd.Prim:
    """Triangles without subdivision; normals per vertex if the mesh has them, else per face."""
    values = {
        "points": points(mesh.vertices),
        "faceVertexCounts": Vt.IntArray(len(mesh.faces), 3),
        "faceVertexIndices": Vt.IntArray.FromNumpy(np.ascontiguousarray(mesh.faces.ravel(), dtype=np.int32)),
        "subdivisionScheme": "none",
        "extent": points(mesh.bounds),
        "normals": points(mesh.normals if mesh.normals is not None else face_normals(mesh)),
    }
    geom = UsdGeom.Mesh(put(stage.DefinePrim(path, "Mesh"), values))
    geom.SetNormalsInterpolation("vertex" if mesh.normals is not None else "uniform")
    if mesh.uv is not None:
        st = UsdGeom.PrimvarsAPI(geom).CreatePrimvar("st", _TYPES.TexCoord2fArray, "vertex")
        st.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(mesh.uv, dtype=np.float32)))
    return geom.GetPrim()


def face_normals(mesh: Mesh) -> npt.NDArray[np.float64]:
    """(F, 3) unit normals; z for faces without area, so that every normal has length one."""
    normals, areas = surface.face_normals(mesh.vertices, mesh.faces.astype(np.int64))
    normals[areas == 0] = (0.0, 0.0, 1.0)
    return normals


def define_colliders(stage: Usd.Stage, root: Sdf.Path, link: Link) -> None:
    """Colliders of a link below `<root>/<link>/collision`."""
    if not link.colliders:
        return
    path = root.AppendChild(link.name).AppendChild("collision")
    # Guides are not rendered, but SimReady counts a collider with the same mesh as a visual (a box, a fixture) as a
    # duplicate unless it is invisible.
    put(stage.DefinePrim(path, "Scope"), {"visibility": "invisible"})
    for collider in link.colliders:
        prim = _define_shape(stage, path.AppendChild(collider.name), collider.shape, collider.pose)
        _set_collision(prim, collider)
        # Twice: PhysX and Newton read the `physics` binding, MuJoCo only the one for all purposes.
        _bind(prim, root, CONTACTS, collider.substance)
        _bind(prim, root, CONTACTS, collider.substance, "physics")


def _define_shape(stage: Usd.Stage, path: Sdf.Path, shape: Shape, pose: Pose) -> Usd.Prim:
    """Guide gprim of a shape; a box is a unit cube under a scale, since USD has no other."""
    scale, half, values = None, None, dict[str, object]()
    if isinstance(shape, Box):
        prim, half, scale, values = stage.DefinePrim(path, "Cube"), np.full(3, 0.5), shape.size, {"size": 1.0}
    elif isinstance(shape, Sphere):
        prim, half, values = stage.DefinePrim(path, "Sphere"), np.full(3, shape.radius), {"radius": shape.radius}
    elif isinstance(shape, Cylinder | Capsule):
        prim = stage.DefinePrim(path, "Cylinder" if isinstance(shape, Cylinder) else "Capsule")
        cap = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, shape.height / 2 + cap])
        values = {"axis": "Z", "radius": shape.radius, "height": shape.height}
    else:
        prim = _define_mesh(stage, path, shape.mesh)
    extent = None if half is None else points(np.array([-half, half]))
    place(put(prim, {**values, "extent": extent, "purpose": "guide"}), pose, scale)
    return prim


def _set_collision(prim: Usd.Prim, collider: Collider) -> None:
    """Label and collision schemas."""
    if collider.label is not None:
        attach_label(prim, PART, [collider.label])
    put(prim, {}, "PhysicsCollisionAPI")
    if isinstance(collider.shape, Hull):
        values = {"physics:approximation": "convexHull", "newton:maxHullVertices": MAX_HULL_VERTICES}
        put(prim, values, "PhysicsMeshCollisionAPI", "NewtonMeshCollisionAPI")
    elif prim.IsA(UsdGeom.Mesh):
        put(prim, {"physics:approximation": "none"}, "PhysicsMeshCollisionAPI")
    condim = contact_dimensions(collider.shape)
    put(prim, {"mjc:condim": condim, "mjc:group": VIEWER_GROUPS.colliders}, "MjcCollisionAPI")


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
        prim = _define_shape(stage, scope.AppendChild(item.name), shape, item.pose)
        group = site_group(item) if isinstance(item, Site) else VIEWER_GROUPS.regions
        put(prim, {"mjc:group": group}, "NewtonSiteAPI", "MjcSiteAPI")
        if isinstance(item, Site):
            put(prim, {"primvars:displayColor": [item.color[:3]], "primvars:displayOpacity": [item.color[3]]})
