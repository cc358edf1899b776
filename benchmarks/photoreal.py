"""Path-traced stills of ten kitchens, one of each plan in ten styles: seconds of each, and what is wrong with it.

    ./dev bench photoreal                      builds them, lived in, into out/bench/photoreal first, a minute each
    ./dev bench photoreal --scenes FOLDER      draws those that are there
    ./dev bench photoreal --only galley        plans whose name begins so
    ./dev bench photoreal --twice              draws each twice and compares the bytes

Needs Blender, see docs/howto/use/photoreal.md. Prints wall and processor seconds, black pixels and fireflies of each,
and writes JPEGs of at most 120 kB into docs/pictures/photoreal, and a sheet of nine, docs/pictures/photoreal.jpg.
"""

from __future__ import annotations

import argparse
import io
import resource
import time
from pathlib import Path

from PIL import Image

from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.kitchens.scene_folders import build_one
from casa_assets.preview.photoreal.render import Still, StillSettings, picture_faults, scene_stills
from casa_assets.preview.photoreal.views import EYE

ROOT = Path(__file__).parents[1]
OUT, PICTURES = ROOT / "out" / "bench" / "photoreal", ROOT / "docs" / "pictures" / "photoreal"
OBJECTS = 40
MOST_BYTES, MOST_SHEET_BYTES = 120_000, 250_000
LEFT_OUT = ("scandinavian",)  # of the sheet: three rows of three
COLUMNS, CELL_PX, GAP_PX = 3, (420, 236), 6
KITCHENS = (
    ("galley", "modern_2"),
    ("u_large", "traditional_1"),
    ("g_small", "rustic"),
    ("one_wall_small", "industrial"),
    ("one_wall_large", "mediterranean"),
    ("l_large", "modern_1"),
    ("u_small", "scandinavian"),
    ("g_large", "transitional_1"),
    ("wraparound", "farmhouse"),
    ("l_small", "coastal"),
)


def main() -> None:
    """Build what is missing, draw, measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=Path, default=OUT)
    parser.add_argument("--only", default="")
    parser.add_argument("--twice", action="store_true")
    given = parser.parse_args()
    print(f"{'kitchen':34} {'wall s':>7} {'cpu s':>7} {'black':>6} {'fireflies':>10} {'same bytes':>11}")
    for plan, style in KITCHENS:
        if not plan.startswith(given.only):
            continue
        folder = given.scenes / f"{plan}__{style}__o{OBJECTS}"
        if not folder.is_dir():
            build_one(SceneRecipe(plan, style, objects=OBJECTS), given.scenes, drawn=False)
        still, wall_s, cpu_s = measured(folder)
        faults = picture_faults(still.pixels)
        same = ("yes" if measured(folder)[0].png == still.png else "no") if given.twice else "-"
        row = f"{wall_s:7.0f} {cpu_s:7.0f} {faults.black:6} {faults.fireflies:10} {same:>11}"
        print(f"{folder.name:34} {row}", flush=True)
        PICTURES.mkdir(parents=True, exist_ok=True)
        (PICTURES / f"{plan}__{style}.jpg").write_bytes(jpeg(Image.fromarray(still.pixels), MOST_BYTES))
    PICTURES.with_suffix(".jpg").write_bytes(jpeg(sheet(), MOST_SHEET_BYTES))


def measured(folder: Path) -> tuple[Still, float, float]:
    """The still at eye level, and its wall and processor seconds, reading included."""
    begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    (still,) = scene_stills(folder, [EYE], StillSettings())
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return still, time.perf_counter() - begin, cpu_s


def sheet() -> Image.Image:
    """As many of the pictures that are there as fill rows."""
    files = [PICTURES / f"{plan}__{style}.jpg" for plan, style in KITCHENS if style not in LEFT_OUT]
    there = [path for path in files if path.is_file()]
    rows = max(1, len(there) // COLUMNS)
    step = [size + GAP_PX for size in CELL_PX]
    whole = Image.new("RGB", (COLUMNS * step[0] - GAP_PX, rows * step[1] - GAP_PX), "white")
    for k, path in enumerate(there[: rows * COLUMNS]):
        cell = Image.open(path).resize(CELL_PX, Image.Resampling.LANCZOS)
        whole.paste(cell, (k % COLUMNS * step[0], k // COLUMNS * step[1]))
    return whole


def jpeg(image: Image.Image, most_bytes: int) -> bytes:
    """JPEG of a picture, of the best quality that `most_bytes` allow."""
    for quality in range(92, 40, -3):
        out = io.BytesIO()
        image.save(out, "JPEG", quality=quality, optimize=True)
        if out.tell() <= most_bytes:
            break
    return out.getvalue()


if __name__ == "__main__":
    main()
