"""Writes Blender files into a folder: a sound one, and one that would run, read and link what lies outside.

    python make_blends.py FOLDER SECRET_PICTURE CANARY

Runs in Blender's own environment.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy


def cube(picture: str = "", *, packed: bool = False) -> bpy.types.Object:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.unit_settings.scale_length = 0.01
    bpy.ops.mesh.primitive_cube_add(size=10, location=(0, 0, 20))
    made = bpy.context.object
    if picture:
        image = bpy.data.images.load(picture)
        if packed:
            image.pack()
        material = bpy.data.materials.new("paint")
        material.use_nodes = True
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        surface = material.node_tree.nodes["Principled BSDF"]
        material.node_tree.links.new(node.outputs["Color"], surface.inputs["Base Color"])
        made.data.materials.append(material)
    return made


def main() -> None:
    folder, secret, canary = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
    cube(secret, packed=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "sound.blend"), compress=True)
    made = cube(secret)
    text = bpy.data.texts.new("run.py")
    text.write(f"open({canary!r}, 'w').write('run')\n")
    text.use_module = True  # run when the file is opened, where that is allowed
    driver = made.driver_add("location", 0).driver
    driver.expression = f"open({canary!r}, 'w').write('driven')"
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "hostile.blend"))


main()
