"""Material -> UsdPreviewSurface; substance -> physics material."""

from __future__ import annotations

from dataclasses import dataclass

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from casa_assets.export.usd import label, number
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture

# Scope names are camelCase, which no link id is, so that they never meet a link of the same name.
SURFACES = "visualMaterials"
CONTACTS = "physicsMaterials"
# Ref: PNG (Third Edition) 11.2.1, colour type in IHDR; 4 and 6 carry alpha.
GREY = (0.5, 0.5, 0.5)
PNG_COLOR_TYPE = 25
PNG_WITH_ALPHA = (4, 6)


@dataclass(frozen=True)
class MaterialPrims:
    """Material prims: `surfaces` by material id, `contacts` by substance id."""

    surfaces: dict[str, UsdShade.Material]
    contacts: dict[str, UsdShade.Material]


def define_all(stage: Usd.Stage, root: Sdf.Path, asset: Asset, textures: str) -> MaterialPrims:
    """Every material and substance of the asset below its root; `textures` leads from the layer to the pictures."""
    surfaces: dict[str, UsdShade.Material] = {}
    if asset.materials:
        scope = UsdGeom.Scope.Define(stage, root.AppendChild(SURFACES)).GetPath()
        for item in asset.materials:
            surfaces[item.id] = _surface(stage, scope.AppendChild(item.id), item, textures)
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
    spin, roll = substance.torsional_friction, substance.rolling_friction
    number.author(prim, "newton:torsionalFriction", Sdf.ValueTypeNames.Float, spin, uniform=False)
    number.author(prim, "newton:rollingFriction", Sdf.ValueTypeNames.Float, roll, uniform=False)
    # MuJoCo takes the all-purpose material of a collider for a look, and warns where it has none.
    shader = UsdShade.Shader.Define(stage, path.AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*GREY))
    shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(substance.metallic)
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(substance.roughness)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    label.attach(prim, "material", [substance.id])
    return material


def _surface(stage: Usd.Stage, path: Sdf.Path, item: Material, textures: str) -> UsdShade.Material:
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, path.AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    reader = _reader(stage, path) if item.textures else None
    _color(stage, path, item, shader, reader, textures)
    _metal(stage, path, item, shader, reader, textures)
    if item.normal_texture is not None:
        node = _texture(stage, path.AppendChild("normal"), item.normal_texture, reader, textures)
        # 0..1 -> -1..1, as UsdPreviewSurface wants of an 8 bit map.
        node.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(2, 2, 2, 1))
        node.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(-1, -1, -1, 0))
        _connect(shader, "normal", Sdf.ValueTypeNames.Normal3f, node, "rgb", Sdf.ValueTypeNames.Float3)
    if item.glow:
        _glow(stage, path, item, shader, reader, textures)
    label.attach(material.GetPrim(), "material", [item.substance])
    return material


def _color(
    stage: Usd.Stage,
    path: Sdf.Path,
    item: Material,
    shader: UsdShade.Shader,
    reader: UsdShade.Shader | None,
    textures: str,
) -> None:
    red, green, blue, alpha = item.base_color
    if item.base_color_texture is None:
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(red, green, blue))
        shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(alpha)
        return
    node = _texture(stage, path.AppendChild("base_color"), item.base_color_texture, reader, textures)
    if item.base_color != (1.0, 1.0, 1.0, 1.0):
        node.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(red, green, blue, alpha))
    _connect(shader, "diffuseColor", Sdf.ValueTypeNames.Color3f, node, "rgb", Sdf.ValueTypeNames.Float3)
    if item.base_color_texture.png[PNG_COLOR_TYPE] in PNG_WITH_ALPHA:
        # A node of its own: SimReady wants alpha read as raw numbers, and one node has one colour space.
        mask = _texture(stage, path.AppendChild("opacity"), item.base_color_texture, reader, textures)
        mask.GetInput("sourceColorSpace").Set("raw")
        if alpha != 1.0:
            mask.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(1, 1, 1, alpha))
        _connect(shader, "opacity", Sdf.ValueTypeNames.Float, mask, "a", Sdf.ValueTypeNames.Float)
    else:
        shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(alpha)


def _glow(
    stage: Usd.Stage,
    path: Sdf.Path,
    item: Material,
    shader: UsdShade.Shader,
    reader: UsdShade.Shader | None,
    textures: str,
) -> None:
    """A share of the base colour; where that is a picture (a display), of the picture."""
    red, green, blue = (item.glow * c for c in item.base_color[:3])
    if item.base_color_texture is None:
        shader.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(red, green, blue))
        return
    node = _texture(stage, path.AppendChild("glow"), item.base_color_texture, reader, textures)
    node.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(red, green, blue, 1))
    _connect(shader, "emissiveColor", Sdf.ValueTypeNames.Color3f, node, "rgb", Sdf.ValueTypeNames.Float3)


def _metal(
    stage: Usd.Stage,
    path: Sdf.Path,
    item: Material,
    shader: UsdShade.Shader,
    reader: UsdShade.Shader | None,
    textures: str,
) -> None:
    if item.metallic_roughness_texture is None:
        shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(item.metallic)
        shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(item.roughness)
        return
    node = _texture(stage, path.AppendChild("metallic_roughness"), item.metallic_roughness_texture, reader, textures)
    if (item.roughness, item.metallic) != (1.0, 1.0):
        node.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(1, item.roughness, item.metallic, 1))
    _connect(shader, "roughness", Sdf.ValueTypeNames.Float, node, "g", Sdf.ValueTypeNames.Float)
    _connect(shader, "metallic", Sdf.ValueTypeNames.Float, node, "b", Sdf.ValueTypeNames.Float)


def _reader(stage: Usd.Stage, path: Sdf.Path) -> UsdShade.Shader:
    reader = UsdShade.Shader.Define(stage, path.AppendChild("st"))
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    return reader


def _texture(
    stage: Usd.Stage, path: Sdf.Path, texture: Texture, reader: UsdShade.Shader | None, textures: str
) -> UsdShade.Shader:
    node = UsdShade.Shader.Define(stage, path)
    node.CreateIdAttr("UsdUVTexture")
    node.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"{textures}/{texture.file_name}")
    space = "sRGB" if texture.color_space is ColorSpace.SRGB else "raw"
    node.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set(space)
    node.CreateInput("wrapS", Sdf.ValueTypeNames.Token).Set("repeat")
    node.CreateInput("wrapT", Sdf.ValueTypeNames.Token).Set("repeat")
    assert reader is not None
    _connect(node, "st", Sdf.ValueTypeNames.Float2, reader, "result", Sdf.ValueTypeNames.Float2)
    return node


def _connect(
    target: UsdShade.Shader,
    to: str,
    kind: Sdf.ValueTypeName,
    source: UsdShade.Shader,
    out: str,
    gives: Sdf.ValueTypeName,
) -> None:
    source.CreateOutput(out, gives)
    target.CreateInput(to, kind).ConnectToSource(source.ConnectableAPI(), out)
