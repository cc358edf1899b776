"""Opens a kitchen's USD in Blender, draws it with Cycles through one of its cameras, prints what came of it as JSON.

    python blender_kitchen.py scene.usda CAMERA picture.png

Runs in Blender's own environment. Lights, materials and places are what the USD says; the ceiling is hidden by its
variant. Colours are shown as they are (`Standard`), so that a picture that is too bright is clipped here, where
Blender's own `AgX` would hide it. Two things a user of Blender has to know: light from all sides is left out where the
scene that is imported into has no world, and a sun becomes four times as bright as USD defines it (a normalised
distant light of intensity pi lights a surface of albedo 0.5 to 2, a ball of the same strength rightly to 0.5).
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

WIDTH, HEIGHT, SAMPLES = 640, 480, 16
SUN = 4.0  # by how much Blender 5.0 brightens the distant lights of USD
# A layer above the scene, as a user would make it.
OPENED = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
    subLayers = [@{scene}@]
)

over "World" (
    variants = {{
        string ceiling = "hidden"
    }}
)
{{
}}
"""


def main() -> None:
    file, camera, picture = sys.argv[1], sys.argv[2], Path(sys.argv[3]).resolve()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.world = bpy.data.worlds.new("World")
    with tempfile.TemporaryDirectory() as folder:
        layer = Path(folder) / "opened.usda"
        layer.write_text(OPENED.format(scene=Path(file).resolve().as_posix()), encoding="utf-8")
        bpy.ops.wm.usd_import(filepath=str(layer), import_guide=False, import_proxy=False)
    for light in [light for light in bpy.data.lights if light.type == "SUN"]:
        light.energy /= SUN
    frame(camera, picture)
    bpy.ops.render.render(write_still=True)
    pixels = pixels_of(picture)
    meshes = [o for o in bpy.data.objects if o.type == "MESH"]
    found = {
        "blender": bpy.app.version_string,
        "cameras": sorted(o.name for o in bpy.data.objects if o.type == "CAMERA"),
        "lights": sorted(o.name for o in bpy.data.objects if o.type == "LIGHT"),
        "bare": sorted(o.name for o in meshes if not o.hide_render and not any(s.material for s in o.material_slots)),
        "from_all_sides": light_from_all_sides(),
        "pictures": sorted(i.name for i in bpy.data.images if i.has_data or i.size[0]),
        "missing": sorted(i.filepath for i in bpy.data.images if i.source == "FILE" and not i.size[0]),
        "mean": float(pixels.mean()),
        "black": float((pixels.max(axis=2) < 4).mean()),
        "white": float((pixels.min(axis=2) > 251).mean()),
        "colors": len(np.unique((pixels // 8).reshape(-1, 3), axis=0)),
    }
    print(json.dumps(found))


def frame(camera: str, picture: Path) -> None:
    scene = bpy.context.scene
    scene.camera = bpy.data.objects[camera]
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", SAMPLES, True
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(picture)


def light_from_all_sides() -> list[float]:
    """Red, green and blue of the background."""
    shader = next(node for node in bpy.context.scene.world.node_tree.nodes if node.type == "BACKGROUND")
    strength = shader.inputs["Strength"].default_value
    return [float(v * strength) for v in shader.inputs["Color"].default_value[:3]]


def pixels_of(picture: Path) -> np.ndarray:
    """(height, width, 3) 0 to 255, of a picture on disk."""
    image = bpy.data.images.load(str(picture))
    values = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(values)
    width, height = image.size
    return (values.reshape(height, width, 4)[..., :3] * 255).round().astype(int)


if __name__ == "__main__":
    main()
