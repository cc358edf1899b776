"""Finishes that UsdPreviewSurface cannot express: glass, the grain of brushed metal, clear coats, lamps that are on.

A material of our USD is named after its finish, and its numbers decide the rest: see-through materials are glass or
liquids, metallic ones that are not polished are brushed, and those that emit light are lamps, displays or flames.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import bpy

PANE_M = 0.016  # what is see-through and thinner is a pane, not a vessel
REFRACTION = {"glass": 1.5, "plastic": 1.49, "liquid": 1.33}
# Metals with a grain, lacquers and stones with a film over the colour, cloth: by the first word of their finish.
BRUSHED = ("stainless_brushed", "stainless_black", "nickel", "brass_brushed", "aluminium", "steel_brushed", "gunmetal")
COATED = {
    "lacquer": (1.0, 0.03),
    "enamel": (0.8, 0.06),
    "paint": (0.35, 0.22),
    "painted": (0.3, 0.25),
    "thermofoil": (0.3, 0.25),
    "ceramic": (0.7, 0.08),
    "fireclay": (0.8, 0.05),
    "skin_glaze": (0.7, 0.08),
    "marble": (0.5, 0.08),
    "granite": (0.5, 0.08),
    "quartz": (0.4, 0.12),
}
CLOTH = ("linen", "fabric", "rope", "wool", "cotton")
# Finishes that give off light; of all else the glow is a help for renderers in which glass throws a shadow.
LAMPS = ("bulb", "glass_opal")
SIGNS = ("led", "display", "flame", "heating_element_hot")
LAMP_STRENGTH, SIGN_STRENGTH = 9.0, 2.5


def add_node(tree: Any, kind: str, values: dict[str | int, Any] | None = None) -> Any:
    """A new node of a tree, with values of its inputs."""
    node = tree.nodes.new(kind)
    for name, value in (values or {}).items():
        node.inputs[name].default_value = value
    return node


def link(tree: Any, *pairs: tuple[Any, Any]) -> None:
    """Connect outputs to inputs."""
    for output, socket in pairs:
        tree.links.new(output, socket)


def finish_of(name: str) -> str:
    """Finish that a material is named by: Blender numbers those that have the same name."""
    return re.sub(r"\.\d{3,}$", "", name)


def is_lamp(material: Any) -> bool:
    """True if a material is that of a bulb or of the glass round it."""
    return material is not None and finish_of(material.name).startswith(LAMPS)


def refine_all(objects: Iterable[Any]) -> None:
    """Refine the material of each mesh; panes and vessels that share one get a copy each."""
    panes: dict[Any, Any] = {}
    done = set()
    for thing in objects:
        for slot in thing.material_slots:
            material = slot.material
            if material is None or _shader(material) is None:
                continue
            if _is_clear(material) and min(thing.dimensions) < PANE_M and not _is_liquid(material):
                if material not in panes:
                    panes[material] = material.copy()
                    _make_pane(panes[material])
                slot.link = "OBJECT"
                slot.material = panes[material]
            elif material not in done:
                done.add(material)
    for material in sorted(done, key=lambda m: m.name):
        refine(material)


def refine(material: Any) -> None:
    """Refine one material of USD."""
    name, shader = finish_of(material.name), _shader(material)
    _set_light(material, shader, name)
    if _is_clear(material):
        _make_clear(material, shader)
        return
    metallic = shader.inputs["Metallic"]
    if not metallic.is_linked and metallic.default_value >= 0.7:
        if name.startswith(BRUSHED):
            _brush(material, shader)
        elif shader.inputs["Roughness"].default_value > 0.12:
            _smudge(material, shader, 0.06)
        return
    for words, (weight, roughness) in COATED.items():
        if name.startswith(words):
            shader.inputs["Coat Weight"].default_value = weight
            shader.inputs["Coat Roughness"].default_value = roughness
            break
    if name.startswith(CLOTH):
        shader.inputs["Sheen Weight"].default_value = 0.3
    if not shader.inputs["Roughness"].is_linked:
        _smudge(material, shader, 0.06)


def _shader(material: Any) -> Any:
    nodes = material.node_tree.nodes if material.node_tree else ()
    return next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)


def _alpha(material: Any) -> float:
    socket = _shader(material).inputs["Alpha"]
    return 1.0 if socket.is_linked else float(socket.default_value)


def _is_clear(material: Any) -> bool:
    return _alpha(material) < 0.999 and not finish_of(material.name).startswith(("sieve", "flame"))


def _is_liquid(material: Any) -> bool:
    words = ("oil", "vinegar", "water", "soap", "liquid", "drink", "food", "ice")
    return finish_of(material.name).startswith(words)


def _set_light(material: Any, shader: Any, name: str) -> None:
    strength = shader.inputs["Emission Strength"]
    if strength.default_value <= 0 and not shader.inputs["Emission Color"].is_linked:
        return
    if name.startswith(LAMPS):
        strength.default_value = LAMP_STRENGTH
    elif name.startswith(SIGNS):
        strength.default_value = SIGN_STRENGTH
    else:
        strength.default_value = 0.0
    # The light itself comes from lamps beside it; what is hit by chance would be specks.
    material.cycles.emission_sampling = "NONE"


def _tint(shader: Any, alpha: float) -> tuple[float, float, float, float]:
    """Share of light that passes: white where hardly anything is kept, the finish's colour where much is."""
    color = tuple(shader.inputs["Base Color"].default_value)[:3]
    brightest = max(*color, 1e-3)
    hue = [min(1.0, c / brightest) for c in color]
    passed = 1.0 - alpha
    red, green, blue = (passed + (1 - passed) * (h * brightest) ** 0.5 * 0.9 for h in hue)
    return red, green, blue, 1.0


def _make_pane(material: Any) -> None:
    """Thin glass: the scene behind, tinted, and a mirror that grows with the angle; light goes straight through."""
    tree, shader = material.node_tree, _shader(material)
    alpha, roughness = _alpha(material), float(shader.inputs["Roughness"].default_value)
    tint = _tint(shader, alpha * 0.6)
    frosted = roughness > 0.3
    if frosted:
        behind = add_node(tree, "ShaderNodeBsdfRefraction", {"Roughness": 0.35, "IOR": 1.0, "Color": tint})
        cloudy = add_node(tree, "ShaderNodeBsdfTranslucent", {"Color": (0.9, 0.93, 0.93, 1.0)})
        through = add_node(tree, "ShaderNodeMixShader", {0: 0.5})
        link(tree, (behind.outputs[0], through.inputs[1]), (cloudy.outputs[0], through.inputs[2]))
    else:
        through = add_node(tree, "ShaderNodeBsdfTransparent", {"Color": tint})
    mirror = add_node(tree, "ShaderNodeBsdfGlossy", {"Roughness": min(roughness, 0.2) * 0.3})
    fresnel, surface = add_node(tree, "ShaderNodeFresnel"), add_node(tree, "ShaderNodeMixShader")
    # On its back, where light would leave the glass, a thin pane mirrors as on its front: no total reflection within.
    side, index = add_node(tree, "ShaderNodeNewGeometry"), add_node(tree, "ShaderNodeMath", {1: 1 / 1.5 - 1.5, 2: 1.5})
    index.operation = "MULTIPLY_ADD"
    link(tree, (side.outputs["Backfacing"], index.inputs[0]), (index.outputs[0], fresnel.inputs["IOR"]))
    link(tree, (fresnel.outputs[0], surface.inputs[0]), (through.outputs[0], surface.inputs[1]))
    link(tree, (mirror.outputs[0], surface.inputs[2]))
    _open_to_light(tree, surface.outputs[0], tint)


def _make_clear(material: Any, shader: Any) -> None:
    """A body of glass, clear plastic or liquid that bends what is behind it, and lets light through."""
    name, alpha = finish_of(material.name), _alpha(material)
    kind = "liquid" if _is_liquid(material) else "glass" if "glass" in name or "bottle" in name else "plastic"
    tint = _tint(shader, alpha)
    roughness = float(shader.inputs["Roughness"].default_value)
    shader.inputs["Alpha"].default_value = 1.0
    shader.inputs["Base Color"].default_value = tint
    shader.inputs["Roughness"].default_value = 0.4 if roughness > 0.3 else 0.02
    shader.inputs["IOR"].default_value = REFRACTION[kind]
    shader.inputs["Transmission Weight"].default_value = 1.0
    _open_to_light(material.node_tree, shader.outputs[0], tint)


def _open_to_light(tree: Any, surface: Any, tint: tuple[float, float, float, float]) -> None:
    """Connect a surface to the output so that light on its way to a lamp, or thrown back softly, passes it unbent."""
    path, either = add_node(tree, "ShaderNodeLightPath"), add_node(tree, "ShaderNodeMath")
    clear, mixed = add_node(tree, "ShaderNodeBsdfTransparent", {"Color": tint}), add_node(tree, "ShaderNodeMixShader")
    either.operation = "MAXIMUM"
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    link(tree, (path.outputs["Is Shadow Ray"], either.inputs[0]), (path.outputs["Is Diffuse Ray"], either.inputs[1]))
    link(tree, (either.outputs[0], mixed.inputs[0]), (surface, mixed.inputs[1]), (clear.outputs[0], mixed.inputs[2]))
    link(tree, (mixed.outputs[0], output.inputs["Surface"]))


def _brush(material: Any, shader: Any) -> None:
    """Fine level scratches: highlights are drawn out across them."""
    tree = material.node_tree
    place = add_node(tree, "ShaderNodeTexCoord")
    noise = stretched_noise(tree, place.outputs["Object"], (1.5, 1.5, 250.0), 1.0)
    _range(tree, noise, shader, float(shader.inputs["Roughness"].default_value), 0.05)
    tangent = add_node(tree, "ShaderNodeTangent")
    tangent.direction_type, tangent.axis = "RADIAL", "Z"
    shader.inputs["Anisotropic"].default_value = 0.6
    link(tree, (tangent.outputs[0], shader.inputs["Tangent"]))


def stretched_noise(tree: Any, vector: Any, scale: tuple[float, float, float], detail: float) -> Any:
    """Output of noise over places that are scaled along each axis."""
    stretch = add_node(tree, "ShaderNodeMapping", {"Scale": scale})
    noise = add_node(tree, "ShaderNodeTexNoise", {"Scale": 1.0, "Detail": detail})
    link(tree, (vector, stretch.inputs["Vector"]), (stretch.outputs[0], noise.inputs["Vector"]))
    return noise.outputs[0]


def _smudge(material: Any, shader: Any, share: float) -> None:
    """Gloss that differs from place to place by a share of itself, as of anything that is used."""
    tree = material.node_tree
    place = add_node(tree, "ShaderNodeTexCoord")
    noise = add_node(tree, "ShaderNodeTexNoise", {"Scale": 5.0, "Detail": 1.0})
    link(tree, (place.outputs["Object"], noise.inputs["Vector"]))
    middle = float(shader.inputs["Roughness"].default_value)
    _range(tree, noise.outputs[0], shader, middle, share * middle)


def _range(tree: Any, noise: Any, shader: Any, middle: float, reach: float) -> None:
    """Connect a noise to the roughness, `reach` about `middle`."""
    low, high = max(0.02, middle - reach), min(1.0, middle + reach)
    ranged = add_node(tree, "ShaderNodeMapRange", {"To Min": low, "To Max": high, "From Min": 0.3, "From Max": 0.7})
    link(tree, (noise, ranged.inputs["Value"]), (ranged.outputs[0], shader.inputs["Roughness"]))


def plain(name: str, color: tuple[float, float, float], roughness: float) -> Any:
    """A material of one colour (linear RGB)."""
    material = bpy.data.materials.new(name)
    shader = _shader(material)
    shader.inputs["Base Color"].default_value = (*color, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    return material
