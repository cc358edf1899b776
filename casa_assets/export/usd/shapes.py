"""Visuals, colliders, sites, regions and materials -> prims and attributes of USD."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from casa_assets.export.mujoco_values import VIEWER_GROUPS, contact_dimensions, site_group
from casa_assets.export.usd import joint, number
from casa_assets.geometry.mesh import surface
from casa_assets.model.asset.asset import Asset, Collider, Link, Region, Site
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.asset.parts import MAX_HULL_VERTICES, Box, Capsule, Cylinder, Hull, Mesh, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

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
    prim.AddAppliedSchema("NewtonMaterialAPI")
    torsional, rolling = substance.torsional_friction, substance.rolling_friction
    number.author(prim, "newton:torsionalFriction", Sdf.ValueTypeNames.Float, torsional, uniform=False)
    number.author(prim, "newton:rollingFriction", Sdf.ValueTypeNames.Float, rolling, uniform=False)
    # MuJoCo reads the all-purpose material of a collider as its appearance, and warns where it has no surface.
    shader = _shader(stage, path.AppendChild("surface"), "UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*GREY))
    shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(substance.metallic)
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(substance.roughness)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    joint.attach_label(prim, "material", [substance.id])
    return material


def _surface(stage: Usd.Stage, path: Sdf.Path, material: Material, textures: str) -> UsdShade.Material:
    prim = UsdShade.Material.Define(stage, path)
    shader = _shader(stage, path.AppendChild("surface"), "UsdPreviewSurface")
    prim.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    _Surface(stage, path, material, shader, _uv_reader(stage, path) if material.textures else None, textures).define()
    joint.attach_label(prim.GetPrim(), "material", [material.substance])
    return prim


@dataclass(frozen=True)
class _Surface:
    """Inputs of one UsdPreviewSurface.

    Attributes:
        path: path of the material prim.
        shader: the UsdPreviewSurface.
        uv_reader: reader of the primvar `st`, or None if the material has no pictures.
        textures: path from the layer to the folder of the pictures.
    """

    stage: Usd.Stage
    path: Sdf.Path
    material: Material
    shader: UsdShade.Shader
    uv_reader: UsdShade.Shader | None
    textures: str

    def define(self) -> None:
        """Define every input, in the order in which a layer lists them."""
        self._color()
        self._metallic_roughness()
        if self.material.normal_texture is not None:
            node = self._texture("normal", self.material.normal_texture, (2, 2, 2, 1))
            # 0..1 -> -1..1, as UsdPreviewSurface wants of an 8 bit map.
            node.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(-1, -1, -1, 0))
            _connect(self.shader, "normal", Sdf.ValueTypeNames.Normal3f, node, "rgb", Sdf.ValueTypeNames.Float3)
        if self.material.glow:
            self._emission()

    def _set_color(self, name: str, red: float, green: float, blue: float) -> None:
        self.shader.CreateInput(name, Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(red, green, blue))

    def _set_float(self, name: str, value: float) -> None:
        self.shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(value)

    def _connect_color(self, name: str, node: UsdShade.Shader) -> None:
        _connect(self.shader, name, Sdf.ValueTypeNames.Color3f, node, "rgb", Sdf.ValueTypeNames.Float3)

    def _connect_channel(self, name: str, node: UsdShade.Shader, channel: str) -> None:
        _connect(self.shader, name, Sdf.ValueTypeNames.Float, node, channel, Sdf.ValueTypeNames.Float)

    def _color(self) -> None:
        red, green, blue, alpha = self.material.base_color
        texture = self.material.base_color_texture
        if texture is None:
            self._set_color("diffuseColor", red, green, blue)
            self._set_float("opacity", alpha)
            return
        self._connect_color("diffuseColor", self._texture("base_color", texture, (red, green, blue, alpha)))
        if texture.png[PNG_COLOR_TYPE] in PNG_WITH_ALPHA:
            # A node of its own: SimReady wants alpha read as raw numbers, and one node has one colour space.
            node = self._texture("opacity", texture)
            node.GetInput("sourceColorSpace").Set("raw")
            _scale(node, (1, 1, 1, alpha))
            self._connect_channel("opacity", node, "a")
        else:
            self._set_float("opacity", alpha)

    def _emission(self) -> None:
        """A share of the base colour; if that is a picture (a display), of the picture."""
        red, green, blue = (self.material.glow * c for c in self.material.base_color[:3])
        if self.material.base_color_texture is None:
            self._set_color("emissiveColor", red, green, blue)
            return
        node = self._texture("glow", self.material.base_color_texture)
        node.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(red, green, blue, 1))
        self._connect_color("emissiveColor", node)

    def _metallic_roughness(self) -> None:
        metallic, roughness = self.material.metallic, self.material.roughness
        if self.material.metallic_roughness_texture is None:
            self._set_float("metallic", metallic)
            self._set_float("roughness", roughness)
            return
        texture = self.material.metallic_roughness_texture
        node = self._texture("metallic_roughness", texture, (1, roughness, metallic, 1))
        self._connect_channel("roughness", node, "g")
        self._connect_channel("metallic", node, "b")

    def _texture(self, name: str, texture: Texture, scale: Vec4 = (1, 1, 1, 1)) -> UsdShade.Shader:
        """A UsdUVTexture node of that name below the material."""
        assert self.uv_reader is not None, "a material with pictures has one"
        node = _shader(self.stage, self.path.AppendChild(name), "UsdUVTexture")
        node.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"{self.textures}/{texture.file_name}")
        color_space = "sRGB" if texture.color_space is ColorSpace.SRGB else "raw"
        node.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set(color_space)
        node.CreateInput("wrapS", Sdf.ValueTypeNames.Token).Set("repeat")
        node.CreateInput("wrapT", Sdf.ValueTypeNames.Token).Set("repeat")
        _connect(node, "st", Sdf.ValueTypeNames.Float2, self.uv_reader, "result", Sdf.ValueTypeNames.Float2)
        _scale(node, scale)
        return node


def _scale(node: UsdShade.Shader, scale: Vec4) -> None:
    """Set the factors of a picture's channels, unless all are 1."""
    if scale != (1, 1, 1, 1):
        node.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*scale))


def _uv_reader(stage: Usd.Stage, path: Sdf.Path) -> UsdShade.Shader:
    reader = _shader(stage, path.AppendChild("st"), "UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    return reader


def _shader(stage: Usd.Stage, path: Sdf.Path, identifier: str) -> UsdShade.Shader:
    shader = UsdShade.Shader.Define(stage, path)
    shader.CreateIdAttr(identifier)
    return shader


def _connect(
    target: UsdShade.Shader,
    target_input: str,
    input_type: Sdf.ValueTypeName,
    source: UsdShade.Shader,
    source_output: str,
    output_type: Sdf.ValueTypeName,
) -> None:
    source.CreateOutput(source_output, output_type)
    target.CreateInput(target_input, input_type).ConnectToSource(source.ConnectableAPI(), source_output)


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
        cube.CreateExtentAttr(number.extent(np.array([[-0.5] * 3, [0.5] * 3])))
        return cube.GetPrim()
    if isinstance(shape, Sphere):
        ball = UsdGeom.Sphere.Define(stage, path)
        ball.CreateRadiusAttr(shape.radius)
        ball.CreateExtentAttr(number.extent(np.array([[-shape.radius] * 3, [shape.radius] * 3])))
        return ball.GetPrim()
    if isinstance(shape, Cylinder | Capsule):
        kind = UsdGeom.Cylinder if isinstance(shape, Cylinder) else UsdGeom.Capsule
        cylinder = kind.Define(stage, path)
        cylinder.CreateAxisAttr(UsdGeom.Tokens.z)
        cylinder.CreateRadiusAttr(shape.radius)
        cylinder.CreateHeightAttr(shape.height)
        cap = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, shape.height / 2 + cap])
        cylinder.CreateExtentAttr(number.extent(np.array([-half, half])))
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
            prim.AddAppliedSchema("NewtonMeshCollisionAPI")
            number.author(prim, "newton:maxHullVertices", Sdf.ValueTypeNames.Int, MAX_HULL_VERTICES)
    prim.AddAppliedSchema("MjcCollisionAPI")
    number.author(prim, "mjc:condim", Sdf.ValueTypeNames.Int, contact_dimensions(collider.shape))
    number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, VIEWER_GROUPS.colliders)
    # Twice: PhysX and Newton read the `physics` binding, MuJoCo only the one for all purposes.
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    material = materials.contacts[collider.substance]
    binding.Bind(material)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")


# Site -----------------------------------------------------------------------------------------------------------------
# Site and region -> guide gprims that physics ignores and MuJoCo reads as sites.


def define_sites(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Sites and regions below `<root>/<link>/sites`."""
    for site in asset.sites:
        prim = _define(stage, _path(stage, root, site), _shape(site), site.pose)
        red, green, blue, alpha = site.color
        number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, site_group(site))
        UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(red, green, blue)])
        UsdGeom.Gprim(prim).CreateDisplayOpacityAttr([alpha])
    for region in asset.regions:
        prim = _define(stage, _path(stage, root, region), _volume(region.kind, region.size), region.pose)
        number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, VIEWER_GROUPS.regions)


def _path(stage: Usd.Stage, root: Sdf.Path, item: Site | Region) -> Sdf.Path:
    return (
        UsdGeom.Scope.Define(stage, root.AppendChild(item.link).AppendChild("sites")).GetPath().AppendChild(item.name)
    )


def _shape(site: Site) -> Shape:
    return Sphere(radius=site.radius) if site.size is None else _volume(site.kind, site.size)


def _volume(kind: str, size: Vec3) -> Shape:
    if kind == "box":
        return Box(size=size)
    return Cylinder(radius=size[0] / 2, height=size[2])


def _define(stage: Usd.Stage, path: Sdf.Path, shape: Shape, pose: Pose) -> Usd.Prim:
    prim = define_shape(stage, path, shape)
    number.place(prim, pose, shape.size if isinstance(shape, Box) else None)
    UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
    for schema in ("NewtonSiteAPI", "MjcSiteAPI"):
        prim.AddAppliedSchema(schema)
    return prim
