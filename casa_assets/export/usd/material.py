"""Material -> UsdPreviewSurface; substance -> physics material."""

from __future__ import annotations

from dataclasses import dataclass

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from casa_assets.export.usd import label, number
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.record import Vec4

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


def define_all(stage: Usd.Stage, root: Sdf.Path, asset: Asset, textures: str) -> MaterialPrims:
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
    label.attach(prim, "material", [substance.id])
    return material


def _surface(stage: Usd.Stage, path: Sdf.Path, material: Material, textures: str) -> UsdShade.Material:
    prim = UsdShade.Material.Define(stage, path)
    shader = _shader(stage, path.AppendChild("surface"), "UsdPreviewSurface")
    prim.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    _Surface(stage, path, material, shader, _uv_reader(stage, path) if material.textures else None, textures).define()
    label.attach(prim.GetPrim(), "material", [material.substance])
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
