"""Run by Blender's own Python, outside this package: converts `in.blend` of a folder to `out.glb` and `out.json`.

Nothing in the file is executed. Contents of other files are left out (linked libraries, and pictures that are not
packed), since a file may refer to any place on the machine.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path


def main() -> None:
    """Convert the file in the folder that is the last argument."""
    import bpy

    folder = Path(sys.argv[-1])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(folder / "in.blend"), load_ui=False, use_scripts=False)
    notes: dict[str, str] = {}
    _leave_out_foreign(notes)
    _remark(notes)
    scene = bpy.context.scene
    unit = scene.unit_settings
    bpy.ops.export_scene.gltf(
        filepath=str(folder / "out.glb"),
        export_format="GLB",
        export_yup=False,
        export_apply=True,
        export_animations=False,
        export_skins=False,
        export_morph=False,
        export_cameras=False,
        export_lights=False,
        export_gpu_instances=False,
        use_visible=True,
    )
    found = {"metres": unit.scale_length if unit.system != "NONE" else None, "notes": list(notes.items())}
    (folder / "out.json").write_text(json.dumps(found), encoding="utf-8")


def _leave_out_foreign(notes: dict[str, str]) -> None:
    """Remove objects of linked files, and the pictures that lie outside of this one."""
    import bpy

    for thing in list(bpy.data.objects):
        if thing.library is not None or (thing.data is not None and thing.data.library is not None):
            notes["libraries"] = "what linked files hold is left out; make it local in Blender"
            bpy.data.objects.remove(thing, do_unlink=True)
    for image in list(bpy.data.images):
        if image.packed_file is None and image.source in ("FILE", "SEQUENCE", "MOVIE", "TILED"):
            notes["images"] = "pictures that are not packed into the file are left out; pack them in Blender"
            bpy.data.images.remove(image)


def _remark(notes: dict[str, str]) -> None:
    import bpy

    if any(thing.type == "ARMATURE" for thing in bpy.data.objects):
        notes["armatures"] = "a rigged mesh: read in the pose that it was saved in, without its rig"
    if bpy.data.shape_keys:
        notes["shape_keys"] = "morph targets are left out; the shape that was saved is read"
    if bpy.data.actions:
        notes["actions"] = "animations are left out; the pose that was saved is read"
    if bpy.data.texts:
        notes["texts"] = "scripts in the file were not run"


if __name__ == "__main__":
    main()
