"""Values, materials, visuals, colliders, sites and regions -> prims and attributes of USD."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade, Vt

from casa_assets.core.numeric import decimals
from casa_assets.formats.values import VIEWER_GROUPS, contact_dimensions, site_group
from casa_assets.mesh import surface
from casa_assets.model.asset.asset import Asset, Collider, Link, Region, Site
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.asset.parts import MAX_HULL_VERTICES, Box, Capsule, Cylinder, Hull, Mesh, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec4

# Values ---------------------------------------------------------------------------------------------------------------
# Numbers -> the value types of USD. Values that USD stores as float are rounded to float32 only here.

_FLOAT, _DOUBLE, _INT = Sdf.ValueTypeNames.Float, Sdf.ValueTypeNames.Double, Sdf.ValueTypeNames.Int
_COLOR, _TOKEN = Sdf.ValueTypeNames.Color3f, Sdf.ValueTypeNames.Token
# Attributes of schemas (mjc, newton) that this USD build may not have registered: declared type, whether uniform.
_KINDS: dict[str, tuple[Sdf.ValueTypeName, bool]] = {
    **dict.fromkeys(("newton:armature", "newton:damping", "newton:friction"), (_FLOAT, False)),
    **dict.fromkeys(("newton:torsionalFriction", "newton:rollingFriction"), (_FLOAT, False)),
    "newton:massModel": (_TOKEN, True),
    **dict.fromkeys(("newton:maxHullVertices", "mjc:condim", "mjc:group"), (_INT, True)),
    **dict.fromkeys(("mjc:solimplimit", "mjc:solimpfriction"), (Sdf.ValueTypeNames.DoubleArray, True)),
    **dict.fromkeys(("mjc:stiffness", "mjc:springref", "mjc:margin"), (_DOUBLE, True)),
}


def vec3f(values: Sequence[float] | npt.NDArray[np.float64]) -> Gf.Vec3f:
    """Three floats, rounded to float32."""
    return Gf.Vec3f(*(float(v) for v in values))


def vec3d(values: Sequence[float] | npt.NDArray[np.float64]) -> Gf.Vec3d:
    """Three doubles, exact."""
    return Gf.Vec3d(*(float(v) for v in values))


def quatf(quaternion: Vec4) -> Gf.Quatf:
    """(w, x, y, z) -> quaternion, rounded to float32."""
    return Gf.Quatf(*quaternion)


def quatd(quaternion: Vec4) -> Gf.Quatd:
    """(w, x, y, z) -> quaternion, to twelve digits: the last ones differ from processor to processor."""
    return Gf.Quatd(*(decimals(c, 12) for c in quaternion))


def points(array: npt.NDArray[np.float64]) -> Vt.Vec3fArray:
    """(N, 3) float64 -> Vec3fArray."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(array, dtype=np.float32))


def place(prim: Usd.Prim, pose: Pose, scale: Sequence[float] | None = None) -> None:
    """Author translate, orient and scale, in double precision; identity ops are left out.

    Args:
        prim: an Xformable without ops.
        pose: parent_from_prim.
        scale: factors along the prim's own axes, or None.
    """
    xform = UsdGeom.Xformable(prim)
    if any(pose.position):
        xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(vec3d(pose.position))
    if any(pose.quaternion[1:]):
        xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(quatd(pose.quaternion))
    if scale is not None:
        xform.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(vec3d(scale))


def apply(prim: Usd.Prim, schema: str, values: Mapping[str, object]) -> None:
    """Apply a schema that this USD build may not have registered, and set its attributes by their full names."""
    prim.AddAppliedSchema(schema)
    for name, value in values.items():
        kind, is_uniform = _KINDS[name]
        variability = Sdf.VariabilityUniform if is_uniform else Sdf.VariabilityVarying
        prim.CreateAttribute(name, kind, custom=False, variability=variability).Set(value)


def attach_label(prim: Usd.Prim, taxonomy: str, labels: Sequence[str]) -> None:
    """Set the labels of one taxonomy on a prim."""
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr(list(labels))


# Material -------------------------------------------------------------------------------------------------------------

# Names of scopes; camelCase, which no link id is.
SURFACES = "visualMaterials"
CONTACTS = "physicsMaterials"
GREY = (0.5, 0.5, 0.5)
# Ref: PNG (Third Edition) 11.2.1: offset of the colour type, and the types with alpha.
PNG_COLOR_TYPE = 25
PNG_WITH_ALPHA = (4, 6)
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


def define_materials(stage: Usd.Stage, root: Sdf.Path, asset: Asset, textures: str) -> None:
    """Define every material and substance below the asset's root; `textures`: path from the layer to the pictures."""
    if asset.materials:
        scope = UsdGeom.Scope.Define(stage, root.AppendChild(SURFACES)).GetPath()
        for material in asset.materials:
            _Surface(stage, scope.AppendChild(material.id), textures).define(material)
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(CONTACTS)).GetPath()
    for substance in asset.substances:
        _define_contact(stage, scope.AppendChild(substance.id), substance)


def _bind(prim: Usd.Prim, root: Sdf.Path, scope: str, name: str, purpose: str = "") -> None:
    """Bind a prim to a material below the asset's root."""
    material = UsdShade.Material(prim.GetStage().GetPrimAtPath(root.AppendChild(scope).AppendChild(name)))
    strength = (UsdShade.Tokens.weakerThanDescendants, purpose) if purpose else ()
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, *strength)


def _define_contact(stage: Usd.Stage, path: Sdf.Path, substance: Substance) -> None:
    """Friction and density. No restitution: MuJoCo has none and warns about it."""
    material = UsdShade.Material.Define(stage, path)
    physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateStaticFrictionAttr(substance.static_friction)
    physics.CreateDynamicFrictionAttr(substance.dynamic_friction)
    physics.CreateDensityAttr(substance.density)
    torsional, rolling = substance.torsional_friction, substance.rolling_friction
    values = {"newton:torsionalFriction": torsional, "newton:rollingFriction": rolling}
    apply(material.GetPrim(), "NewtonMaterialAPI", values)
    # MuJoCo reads the all-purpose material of a collider as its appearance, and warns where it has no surface.
    shader = _shader(stage, path.AppendChild("surface"), "UsdPreviewSurface")
    _set(shader, diffuseColor=Gf.Vec3f(*GREY), metallic=substance.metallic, roughness=substance.roughness)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    attach_label(material.GetPrim(), "material", [substance.id])


class _Surface:
    """A material that is defined at `path`; `textures`: path from the layer to the folder of the pictures."""

    def __init__(self, stage: Usd.Stage, path: Sdf.Path, textures: str) -> None:
        self._stage, self._path, self._textures = stage, path, textures

    def define(self, material: Material) -> None:
        prim = UsdShade.Material.Define(self._stage, self._path)
        shader = _shader(self._stage, self._path.AppendChild("surface"), "UsdPreviewSurface")
        prim.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        if material.textures:
            reader = _shader(self._stage, self._path.AppendChild("st"), "UsdPrimvarReader_float2")
            _set(reader, varname="st")
            reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        self._set_inputs(shader, material)
        attach_label(prim.GetPrim(), "material", [material.substance])

    def _set_inputs(self, shader: UsdShade.Shader, material: Material) -> None:
        """Inputs of a UsdPreviewSurface, in the order in which a layer lists them."""
        alpha, base = material.base_color[3], material.base_color_texture
        if base is None:
            _set(shader, diffuseColor=Gf.Vec3f(*material.base_color[:3]), opacity=alpha)
        else:
            _feed(shader, "diffuseColor", self._picture("base_color", base, material.base_color), "rgb")
            if base.png[PNG_COLOR_TYPE] in PNG_WITH_ALPHA:
                # A second node: SimReady wants alpha read as raw numbers, and one node has one colour space.
                _feed(shader, "opacity", self._picture("opacity", base, (1, 1, 1, alpha), "raw"), "a")
            else:
                _set(shader, opacity=alpha)
        metallic, roughness = material.metallic, material.roughness
        if material.metallic_roughness_texture is None:
            _set(shader, metallic=metallic, roughness=roughness)
        else:
            scale = (1, roughness, metallic, 1)
            node = self._picture("metallic_roughness", material.metallic_roughness_texture, scale)
            _feed(shader, "roughness", node, "g")
            _feed(shader, "metallic", node, "b")
        if material.normal_texture is not None:
            node = self._picture("normal", material.normal_texture, (2, 2, 2, 1))
            # 0..1 -> -1..1, as UsdPreviewSurface wants of an 8 bit map.
            _set(node, bias=Gf.Vec4f(-1, -1, -1, 0))
            _feed(shader, "normal", node, "rgb")
        if material.glow:
            # A share of the base colour; if that is a picture (a display), of the picture.
            glow = [material.glow * c for c in material.base_color[:3]]
            if base is None:
                _set(shader, emissiveColor=Gf.Vec3f(*glow))
            else:
                node = self._picture("glow", base)
                _set(node, scale=Gf.Vec4f(*glow, 1))
                _feed(shader, "emissiveColor", node, "rgb")

    def _picture(
        self, name: str, texture: Texture, scale: Vec4 = (1, 1, 1, 1), color_space: str = ""
    ) -> UsdShade.Shader:
        """A UsdUVTexture node; `scale`: factors of the channels. `color_space`: other than that of the texture."""
        node = _shader(self._stage, self._path.AppendChild(name), "UsdUVTexture")
        space = color_space or ("sRGB" if texture.color_space is ColorSpace.SRGB else "raw")
        file = f"{self._textures}/{texture.file_name}"
        _set(node, file=file, sourceColorSpace=space, wrapS="repeat", wrapT="repeat")
        _feed(node, "st", UsdShade.Shader(self._stage.GetPrimAtPath(self._path.AppendChild("st"))), "result")
        if scale != (1, 1, 1, 1):
            _set(node, scale=Gf.Vec4f(*scale))
        return node


def _shader(stage: Usd.Stage, path: Sdf.Path, identifier: str) -> UsdShade.Shader:
    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(identifier)
    return shader


def _set(shader: UsdShade.Shader, **values: object) -> None:
    for name, value in values.items():
        shader.CreateInput(name, _INPUTS[name]).Set(value)


def _feed(target: UsdShade.Shader, name: str, source: UsdShade.Shader, output: str) -> None:
    """Connect an input to the output of another node."""
    source.CreateOutput(output, _OUTPUTS[output])
    target.CreateInput(name, _INPUTS[name]).ConnectToSource(source.ConnectableAPI(), output)


# Shapes ---------------------------------------------------------------------------------------------------------------
# Mesh -> Mesh prim; visuals and colliders of a link: a collider is an invisible gprim with a collision API.

# The taxonomy of the part of an asset that a visual or collider is: handle, door, shelf.
PART = "part"


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
        apply(prim, "MjcImageableAPI", {"mjc:group": VIEWER_GROUPS.visuals})
        # MuJoCo refuses a mesh without volume unless it is declared a shell; the body has the mass.
        apply(prim, "NewtonMassAPI", {"newton:massModel": "shell"})


def _define_mesh(stage: Usd.Stage, path: Sdf.Path, mesh: Mesh) -> Usd.Prim:
    """Triangles without subdivision; normals per vertex if the mesh has them, else per face."""
    geom = UsdGeom.Mesh.Define(stage, path)
    geom.CreatePointsAttr(points(mesh.vertices))
    geom.CreateFaceVertexCountsAttr(Vt.IntArray(len(mesh.faces), 3))
    geom.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(mesh.faces.ravel(), dtype=np.int32)))
    geom.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    geom.CreateExtentAttr(points(mesh.bounds))
    geom.CreateNormalsAttr(points(mesh.normals if mesh.normals is not None else face_normals(mesh)))
    geom.SetNormalsInterpolation(UsdGeom.Tokens.vertex if mesh.normals is not None else UsdGeom.Tokens.uniform)
    if mesh.uv is not None:
        st = UsdGeom.PrimvarsAPI(geom).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex)
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
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(link.name).AppendChild("collision"))
    # Guides are not rendered, but SimReady counts a collider with the same mesh as a visual (a box, a fixture) as a
    # duplicate unless it is invisible.
    UsdGeom.Imageable(scope).CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    for collider in link.colliders:
        prim = _define_shape(stage, scope.GetPath().AppendChild(collider.name), collider.shape, collider.pose)
        _set_collision(prim, collider)
        # Twice: PhysX and Newton read the `physics` binding, MuJoCo only the one for all purposes.
        _bind(prim, root, CONTACTS, collider.substance)
        _bind(prim, root, CONTACTS, collider.substance, "physics")


def _define_shape(stage: Usd.Stage, path: Sdf.Path, shape: Shape, pose: Pose) -> Usd.Prim:
    """Guide gprim of a shape; a box is a unit cube under a scale, since USD has no other."""
    scale = None
    if isinstance(shape, Box):
        gprim, half, scale = UsdGeom.Cube.Define(stage, path), np.full(3, 0.5), shape.size
        gprim.CreateSizeAttr(1.0)
    elif isinstance(shape, Sphere):
        gprim, half = UsdGeom.Sphere.Define(stage, path), np.full(3, shape.radius)
        gprim.CreateRadiusAttr(shape.radius)
    elif isinstance(shape, Cylinder | Capsule):
        gprim = (UsdGeom.Cylinder if isinstance(shape, Cylinder) else UsdGeom.Capsule).Define(stage, path)
        gprim.CreateAxisAttr(UsdGeom.Tokens.z)
        gprim.CreateRadiusAttr(shape.radius)
        gprim.CreateHeightAttr(shape.height)
        cap = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, shape.height / 2 + cap])
    else:
        gprim, half = UsdGeom.Mesh(_define_mesh(stage, path, shape.mesh)), None
    if half is not None:
        gprim.CreateExtentAttr(points(np.array([-half, half])))
    place(gprim.GetPrim(), pose, scale)
    gprim.CreatePurposeAttr(UsdGeom.Tokens.guide)
    return gprim.GetPrim()


def _set_collision(prim: Usd.Prim, collider: Collider) -> None:
    """Label and collision schemas."""
    if collider.label is not None:
        attach_label(prim, PART, [collider.label])
    UsdPhysics.CollisionAPI.Apply(prim)
    if prim.IsA(UsdGeom.Mesh):
        hull = isinstance(collider.shape, Hull)
        kind = UsdPhysics.Tokens.convexHull if hull else UsdPhysics.Tokens.none
        UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(kind)
        if hull:
            apply(prim, "NewtonMeshCollisionAPI", {"newton:maxHullVertices": MAX_HULL_VERTICES})
    condim = contact_dimensions(collider.shape)
    apply(prim, "MjcCollisionAPI", {"mjc:condim": condim, "mjc:group": VIEWER_GROUPS.colliders})


# Site -----------------------------------------------------------------------------------------------------------------


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
        prim.AddAppliedSchema("NewtonSiteAPI")
        group = site_group(item) if isinstance(item, Site) else VIEWER_GROUPS.regions
        apply(prim, "MjcSiteAPI", {"mjc:group": group})
        if isinstance(item, Site):
            UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(*item.color[:3])])
            UsdGeom.Gprim(prim).CreateDisplayOpacityAttr([item.color[3]])
