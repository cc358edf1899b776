"""USD stage -> what its visuals look like. Read with OpenUSD alone."""

from __future__ import annotations

from pathlib import PurePosixPath

from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from casa_assets.checks.package.facts import VisualFacts
from casa_assets.checks.readers.mujoco_facts import short_name
from casa_assets.model.record import Vec3, Vec4


def looks(stage: Usd.Stage) -> tuple[VisualFacts, ...]:
    """Meshes that physics does not touch, sorted by name, in the material that they are bound to.

    Raises:
        ValueError: one has no surface to be seen.
    """
    meshes = [p for p in stage.Traverse() if p.IsA(UsdGeom.Mesh) and not p.HasAPI(UsdPhysics.CollisionAPI)]
    # A site is no mesh, so what is left is seen. Materials of all of them are found at once, which shares what they
    # inherit.
    materials = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(meshes)[0]
    surfaces: dict[Usd.Prim, tuple[Vec4, Vec3, str]] = {}
    found = []
    for prim, material in zip(meshes, materials, strict=True):
        bound = material.GetPrim()
        if bound not in surfaces:
            surfaces[bound] = _surface(prim, material)
        color, light, picture = surfaces[bound]
        found.append(VisualFacts(name=short_name(str(prim.GetPath())), color=color, light=light, picture=picture))
    return tuple(sorted(found, key=lambda look: look.name))


def _surface(prim: Usd.Prim, material: UsdShade.Material) -> tuple[Vec4, Vec3, str]:
    """Colour, light that it gives off and picture of a material, as `VisualFacts` has them; `prim` is bound to it."""
    shader = material.ComputeSurfaceSource()[0] if material else None
    if not shader:
        raise ValueError(f"{prim.GetName()!r} has no surface")
    red, green, blue, _ = _value(shader, "diffuseColor")
    opacity, light = _value(shader, "opacity")[3], _three(_value(shader, "emissiveColor"))
    return (red, green, blue, opacity), light, _picture(shader)


def _node(shader: UsdShade.Shader, name: str) -> UsdShade.Shader | None:
    """The texture that feeds an input."""
    port = shader.GetInput(name)
    if not port or not port.HasConnectedSource():
        return None
    return UsdShade.Shader(port.GetConnectedSources()[0][0].source.GetPrim())


def _value(shader: UsdShade.Shader, name: str) -> Vec4:
    """Colour or number of an input, or the factor on its picture; a number is the alpha of white."""
    node = _node(shader, name)
    if node is not None:
        scale = node.GetInput("scale")
        red, green, blue, alpha = (float(n) for n in (scale.Get() if scale else (1, 1, 1, 1)))
        return red, green, blue, alpha
    port = shader.GetInput(name)
    value = port.Get() if port else (0.0, 0.0, 0.0)
    if isinstance(value, float):
        return 1.0, 1.0, 1.0, value
    red, green, blue = (float(n) for n in value)
    return red, green, blue, 1.0


def _picture(shader: UsdShade.Shader) -> str:
    node = _node(shader, "diffuseColor")
    return PurePosixPath(node.GetInput("file").Get().path).name if node is not None else ""


def _three(rgba: Vec4) -> Vec3:
    return rgba[0], rgba[1], rgba[2]
