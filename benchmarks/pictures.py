"""Draws the pictures of README: ten plans in ten styles at eye level and from above, and 24 members of the kit.

    ./dev bench pictures                     builds the kitchens into out/bench/pictures first, a minute each
    ./dev bench pictures --scenes FOLDER     draws those that are there, as they are
    ./dev bench pictures --only kit          kitchens or kit alone

Prints the processor seconds of each kitchen's picture. Writes docs/pictures/kitchens.jpg and kit.jpg: JPEG, as a
palette of 256 colours makes bands of soft light.
"""

from __future__ import annotations

import argparse
import io
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image, ImageOps

from casa_assets.core.system import cache_dir
from casa_assets.families.build import FamilyRequest, build_asset, family_of, params_of
from casa_assets.formats import mjcf
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.scene_folders import build_one
from casa_assets.show.stills import kitchen
from casa_assets.show.stills.pictures import trimmed
from casa_assets.show.stills.still import render
from casa_assets.show.stills.studio import View

ROOT = Path(__file__).parents[1]
OUT, PICTURES = ROOT / "out" / "bench" / "pictures", ROOT / "docs" / "pictures"
# Every plan, each in another style.
SCENES = (
    "l_small__coastal",
    "u_small__scandinavian",
    "galley__industrial",
    "one_wall_large__mediterranean",
    "g_large__transitional_1",
    "one_wall_small__modern_2",
    "l_large__rustic",
    "u_large__traditional_2",
    "g_small__farmhouse",
    "wraparound__modern_1",
)
# Scene, camera and pose of the large pictures.
EYES = (
    ("l_large__rustic", "robot_eye_2", "start"),
    ("l_small__coastal", "robot_eye_1", "start"),
    ("one_wall_large__mediterranean", "robot_eye_2", "open"),
    ("one_wall_small__modern_2", "at_stove", "start"),
)
EYE_PX, TILE_PX, GAP_PX = (800, 520), (319, 210), 5
# Family, preset, pose.
KIT = (
    ("base_cabinet", "shaker_navy_cups", "open"),
    ("wall_cabinet", "glass_divided_cream", "open"),
    ("drawer_stack", "walnut_raised_three", "open"),
    ("sink", "farmhouse", ""),
    ("range", "pro_six", "open"),
    ("hood", "copper_pyramid", ""),
    ("fridge_french_door", "steel", "open"),
    ("hob", "gas_five", ""),
    ("microwave", "steel", "open"),
    ("wall_oven", "retro_cream", ""),
    ("dishwasher", "retro_mint", "open"),
    ("window", "cottage", "open"),
    ("stool", "cafe_red", ""),
    ("chair", "cross_back", ""),
    ("table", "farmhouse", ""),
    ("pendant_light", "globe", ""),
    ("plant", "monstera", ""),
    ("stand_mixer", "classic_red", ""),
    ("coffee_machine", "espresso_retro_cream", ""),
    ("knife_block", "oak_leaning", ""),
    ("utensil_holder", "sage_barrel", ""),
    ("fruit_bowl", "mixed_white", ""),
    ("toaster", "retro_cream", ""),
    ("wall_clock", "sunburst", ""),
)
KIT_COLUMNS, KIT_PX, KIT_FILL = 8, 220, 0.92
QUALITY = 88


def main() -> int:
    """Draw and write them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=Path, help="folder of scenes that were built")
    parser.add_argument("--only", choices=("kitchens", "kit"))
    options = parser.parse_args()
    if options.only != "kit":
        save(kitchens(options.scenes), "kitchens")
    if options.only != "kitchens":
        save(kit(), "kit")
    return 0


def kitchens(folder: Path | None) -> Image.Image:
    """Four large pictures at eye level over ten from above."""
    if folder is None:
        folder = OUT
        for name in SCENES:
            plan, style = name.split("__")
            done = build_one(SceneRecipe(plan, style), folder, drawn=False)
            if not done.folder:
                raise SystemExit(done.message)
    columns = EYE_PX[0] * 2 + GAP_PX
    tiles_across = len(SCENES) // 2
    rows = 2 * (EYE_PX[1] + GAP_PX) + 2 * (TILE_PX[1] + GAP_PX) - GAP_PX
    page = Image.new("RGB", (columns, rows), (255, 255, 255))
    for i, (scene, camera, pose) in enumerate(EYES):
        drawn = ImageOps.fit(draw(folder / scene, camera, pose, EYE_PX[0]), EYE_PX, Image.Resampling.LANCZOS)
        page.paste(drawn, (i % 2 * (EYE_PX[0] + GAP_PX), i // 2 * (EYE_PX[1] + GAP_PX)))
    for i, scene in enumerate(SCENES):
        drawn = trimmed(draw(folder / scene, "overview", "start", 640), TILE_PX[0] / TILE_PX[1])
        across, down = i % tiles_across, i // tiles_across
        corner = (across * (columns + GAP_PX) // tiles_across, 2 * (EYE_PX[1] + GAP_PX) + down * (TILE_PX[1] + GAP_PX))
        page.paste(drawn.resize(TILE_PX, Image.Resampling.LANCZOS), corner)
    return page


def draw(scene: Path, camera: str, pose: str, width_px: int) -> Image.Image:
    """One camera of a scene, 4 to 3; prints the processor seconds that it takes."""
    frame = kitchen.PictureSettings(width_px, width_px * 3 // 4)
    made = kitchen.open_scene(scene / "scene.xml", frame, pose)
    begin = time.process_time()
    ((_, pixels),) = kitchen.render_cameras(made, [camera], frame)
    print(f"{scene.name} {camera}, {width_px} px: {time.process_time() - begin:.1f} s of processor", flush=True)
    return Image.fromarray(pixels)


def kit() -> Image.Image:
    """Members of families in rows, without gaps."""
    rows = -(-len(KIT) // KIT_COLUMNS)
    page = np.full((rows * KIT_PX, KIT_COLUMNS * KIT_PX, 3), 255, dtype=np.uint8)
    with tempfile.TemporaryDirectory() as scratch:
        for i, (family, preset, pose) in enumerate(KIT):
            request = FamilyRequest(family, preset)
            asset = build_asset(family_of(request), params_of(request), cache_dir())
            folder = Path(scratch) / str(i)
            for path, data in mjcf.write(asset).entries.items():
                (folder / path).parent.mkdir(parents=True, exist_ok=True)
                (folder / path).write_bytes(data)
            png = render(folder / "model.xml", View(size_px=KIT_PX, fill=KIT_FILL), pose=pose)
            with Image.open(io.BytesIO(png)) as opened:
                y, x = i // KIT_COLUMNS * KIT_PX, i % KIT_COLUMNS * KIT_PX
                page[y : y + KIT_PX, x : x + KIT_PX] = np.asarray(opened.convert("RGB"))
    return Image.fromarray(page)


def save(picture: Image.Image, name: str) -> None:
    """Write a picture of the documentation, and say where."""
    path = PICTURES / f"{name}.jpg"
    picture.save(path, format="JPEG", quality=QUALITY, subsampling=0, optimize=True)
    print(path, f"{path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    raise SystemExit(main())
