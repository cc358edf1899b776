"""Run by Blender's own Python, away from this package: `job.json` of a folder -> one PNG for each of its views.

python main.py FOLDER        blender --background --python main.py -- FOLDER
"""

from __future__ import annotations

import json
import math
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import bpy
import numpy as np
import surfaces
import surroundings
from mathutils import Matrix, Quaternion, Vector

LAYER = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
    subLayers = [@@@{file}@@@]
)

over "{root}" (
    variants = {{
{variants}
    }}
)
{{
}}
"""
OUTSIDE_BRIGHTNESS = 1.5  # of the sky that is seen through a window; the brightest that a picture shows is about 4
# Typical brightness of a picture; white is about 1. A room from above and a thing in the studio are on white.
GREY = {"room": 0.28, "cutaway": 0.5, "asset": 0.55}
LIGHT_PART, LIGHT_SHARE, WEIGHT = 0.95, 0.9, 0.6  # brightness, of a room, that a share of its pixels does not exceed
# Tone curves and their looks: a room keeps its colours; whites on white need a curve that is soft towards white.
TONE = {
    "room": ("Khronos PBR Neutral", "None"),
    "cutaway": ("AgX", "AgX - Medium High Contrast"),
    "asset": ("AgX", "AgX - Medium High Contrast"),
}
SATURATION = 0.82  # of a room's colours, of those in linear light: a wall of red brick looks painted without it
# Brightness of a white card that is held before what a room's picture shows, and its say beside that of the picture: a
# meter that looked at the picture alone would make white of a room of brick and slate.
CARD, CARD_WEIGHT = 0.74, 0.75
VEILING_GLARE = 0.03  # share of the light that a lens scatters over the picture; ISO 9358 measures 0.01 to 0.03
ADAPTATION, SHADES_NORM = 0.85, 4.0  # share of the light's tint that a camera takes out; norm of shades-of-gray
FILL = 0.9  # share of the picture that what a camera is fitted to spans
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear Rec. 709
ADDED = ("studio",)  # names of things that carry others
PROBE_SHARE, PROBE_SAMPLES = 25, 12  # size in percent and samples of the picture that the exposure is measured on


def main() -> None:
    """Draw the job in the folder that is the last argument."""
    folder = Path(sys.argv[-1])
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    begin = time.perf_counter()
    read(job, folder)
    surfaces.refine_all(o for o in bpy.data.objects if o.type == "MESH")
    set_engine(job)
    outside = light(job)
    drawn: dict[str, Any] = {"read_s": time.perf_counter() - begin, "views": []}
    for view in job["views"]:
        begin = time.perf_counter()
        exposure = draw(view, job, folder, outside)
        drawn["views"].append({"name": view["name"], "seconds": time.perf_counter() - begin, "exposure": exposure})
    (folder / "drawn.json").write_text(json.dumps(drawn), encoding="utf-8")


def light(job: dict[str, Any]) -> Any:
    """Light the scene as its kind asks for; the node that gives what is seen outside its strength, or None."""
    if job["kind"] == "room":
        outside = surroundings.add_world(1.0)
        surroundings.light_room(job["room"], job["beyond_m"], job["sun"])
        return outside
    if job["kind"] == "cutaway":
        looks = Quaternion(job["views"][0]["quaternion"]) @ Vector((0.0, 0.0, -1.0))
        surroundings.light_from_above(looks)
    else:
        surroundings.light_studio(seen_points())
    return None


def read(job: dict[str, Any], folder: Path) -> None:
    """Import the USD with its variants chosen in a layer above it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    layer = folder / "opened.usda"
    variants = "\n".join(f'        string {name} = "{value}"' for name, value in job["variants"].items())
    text = LAYER.format(file=job["usd"], root=job["root"], variants=variants)
    layer.write_text(text, encoding="utf-8")
    bpy.ops.wm.usd_import(filepath=str(layer), import_guide=False, import_proxy=False)
    for camera in [o for o in bpy.data.objects if o.type == "CAMERA"]:
        bpy.data.objects.remove(camera, do_unlink=True)


def set_engine(job: dict[str, Any]) -> None:
    """Cycles on processors, with a fixed seed and number of threads."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.seed, cycles.use_animated_seed = "CPU", job["seed"], False
    cycles.use_denoising, cycles.denoiser = True, "OPENIMAGEDENOISE"
    cycles.denoising_input_passes, cycles.denoising_prefilter = "RGB_ALBEDO_NORMAL", "ACCURATE"
    cycles.use_adaptive_sampling, cycles.adaptive_threshold = True, 0.03
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 9, 5, 4
    cycles.transmission_bounces, cycles.transparent_max_bounces = 8, 16
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.blur_glossy, cycles.sample_clamp_indirect, cycles.sample_clamp_direct = 1.0, 4.0, 0.0
    # With the few lights of a room a tree of them takes a fifth of the time and makes no less noise.
    cycles.use_light_tree = False
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.render.use_persistent_data = True
    scene.render.resolution_x, scene.render.resolution_y = job["width_px"], job["height_px"]
    for stamp in [name for name in dir(scene.render) if name.startswith("use_stamp")]:
        setattr(scene.render, stamp, False)
    scene.view_settings.view_transform, scene.view_settings.look = TONE[job["kind"]]


def draw(view: dict[str, Any], job: dict[str, Any], folder: Path, outside: Any) -> float:
    """Draw one view and return its exposure in stops."""
    scene = bpy.context.scene
    data = bpy.data.cameras.new(view["name"])
    data.sensor_fit, data.angle, data.clip_start = "HORIZONTAL", view["fov_x"], 0.02
    data.shift_y = view["shift_y"]
    camera = surroundings.put(view["name"], data)
    camera.matrix_world = Matrix.Translation(view["position"]) @ Quaternion(view["quaternion"]).to_matrix().to_4x4()
    scene.camera = camera
    if view["fit"] is not None:
        fit(camera, [Vector(point) for point in view["fit"]] or seen_points())
    scene.cycles.samples, scene.render.resolution_percentage = PROBE_SAMPLES, PROBE_SHARE
    light = render(folder / "probe.exr")
    gain = exposure_of(light, job["kind"])
    if job["kind"] == "room":
        falling = falling_light(folder)
        card = CARD / float(np.exp(np.mean(np.log(falling @ LUMINANCE))))
        gain = gain ** (1 - CARD_WEIGHT) * card**CARD_WEIGHT
        scene.view_settings.use_white_balance = True
        scene.view_settings.white_balance_whitepoint = tuple(tint_of(falling) ** ADAPTATION)
    if outside is not None:
        outside.inputs["Strength"].default_value = OUTSIDE_BRIGHTNESS / gain
    scene.cycles.samples, scene.render.resolution_percentage = job["samples"], 100
    render(folder / "light.exr")
    scene.view_settings.exposure = float(np.log2(gain))
    image = bpy.data.images.load(str(folder / "light.exr"), check_existing=False)
    if job["kind"] == "room":
        develop(image, most=4.0 / gain)
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGB"
    scene.render.image_settings.color_depth = "8"
    image.save_render(str(folder / f"{view['name']}.png"), scene=scene)
    bpy.data.images.remove(image)
    return float(scene.view_settings.exposure)


def develop(image: Any, most: float) -> None:
    """Soften the colours, and spread a share of the light, up to what fills a sensor, over the whole picture.

    The glass of every lens scatters light like that, so that gaps are dark, not black.
    """
    values = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(values)
    light = values.reshape(-1, 4)[:, :3]
    light *= SATURATION
    light += (1.0 - SATURATION) / SATURATION * (light @ LUMINANCE)[:, None]
    light *= 1.0 - VEILING_GLARE
    light += VEILING_GLARE * np.mean(np.minimum(light, most), axis=0)
    image.pixels.foreach_set(values)


def fit(camera: Any, points: list[Vector]) -> None:
    """Move a camera so that the points fill FILL of its picture in one direction."""
    angle = camera.data.angle
    camera.data.angle = 2 * math.atan(math.tan(angle / 2) * FILL)
    bpy.context.view_layer.update()
    place, _ = camera.camera_fit_coords(bpy.context.evaluated_depsgraph_get(), [c for p in points for c in p])
    camera.data.angle, camera.location = angle, place


def seen_points() -> list[Vector]:
    """Vertices of everything that was imported, world frame, metres."""
    things = [o for o in bpy.context.scene.objects if o.type == "MESH" and o.visible_get() and o.name not in ADDED]
    return [thing.matrix_world @ vertex.co for thing in things for vertex in thing.data.vertices]


def render(path: Path) -> np.ndarray:
    """Render to an EXR file; (height, width, 3) linear light."""
    scene = bpy.context.scene
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "OPEN_EXR", "RGB"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    values = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(values)
    width, height = image.size
    bpy.data.images.remove(image)
    return values.reshape(height, width, 4)[..., :3]


def falling_light(folder: Path) -> np.ndarray:
    """(N, 3) linear light that falls on visible surfaces but metal and glass: what a white card there would show."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    tree = bpy.data.node_groups.new("meter", "CompositorNodeTree")
    tree.interface.new_socket("light", in_out="OUTPUT", socket_type="NodeSocketColor")
    layer.use_pass_diffuse_direct = layer.use_pass_diffuse_indirect = True
    scene.compositing_node_group, scene.render.use_compositing = tree, True
    passes, total, out = (
        tree.nodes.new(kind) for kind in ("CompositorNodeRLayers", "ShaderNodeMix", "NodeGroupOutput")
    )
    total.data_type, total.blend_type, total.inputs[0].default_value = "RGBA", "ADD", 1.0
    passes.scene = scene
    tree.links.new(passes.outputs["Diffuse Direct"], total.inputs[6])
    tree.links.new(passes.outputs["Diffuse Indirect"], total.inputs[7])
    tree.links.new(total.outputs[2], out.inputs[0])
    light = render(folder / "falling.exr").reshape(-1, 3)
    scene.compositing_node_group, scene.render.use_compositing = None, False
    layer.use_pass_diffuse_direct = layer.use_pass_diffuse_indirect = False
    bpy.data.node_groups.remove(tree)
    lit = light[light.min(axis=1) > 1e-4]
    return lit if len(lit) else np.ones((1, 3), dtype=np.float32)


def exposure_of(light: np.ndarray, kind: str) -> float:
    """Factor that brings a picture to a middle grey; in a room, in part, that which keeps its light parts light."""
    luminance = np.clip(light @ LUMINANCE, 1e-4, None)
    gain = GREY[kind] / float(np.exp(np.mean(np.log(luminance))))
    if kind == "room":
        gain = gain ** (1 - WEIGHT) * (LIGHT_PART / float(np.quantile(luminance, LIGHT_SHARE))) ** WEIGHT
    return float(np.clip(gain, 0.01, 100.0))


def tint_of(light: np.ndarray) -> np.ndarray:
    """Colour (3,) of light (..., 3), of luminance 1, by shades-of-gray (Finlayson and Trezzi, 2004)."""
    luminance = np.clip(light @ LUMINANCE, 1e-4, None)
    most = 4.0 * float(np.exp(np.mean(np.log(luminance))))  # lamps and the garden would speak for the room
    tint: np.ndarray = np.mean(np.clip(light, 0.0, most).reshape(-1, 3) ** SHADES_NORM, axis=0) ** (1 / SHADES_NORM)
    return np.asarray(tint / float(tint @ LUMINANCE))


if __name__ == "__main__":
    main()
