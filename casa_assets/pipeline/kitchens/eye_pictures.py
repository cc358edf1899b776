"""Pictures of kitchens at the height of eyes with their doors open, drawn where they are missing."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from casa_assets.pipeline.kitchens.scene_files import SCENE_JSON
from casa_assets.pipeline.kitchens.scene_folders import WORKER_BYTES, draw_cameras, warm
from casa_assets.pipeline.workers.batch import run_batch
from casa_assets.preview.kitchen import PictureSettings

POSE = "open"
# Cameras at the height of a robot's eyes begin with this word, see `layouts.compose`.
EYE = "robot_eye"
FRAME = PictureSettings(960, 640, passes=4)


def eye_picture_of(folder: Path) -> Path | None:
    """Where the picture of a scene is to be; None where it has no such camera."""
    facts = json.loads((folder / SCENE_JSON).read_text(encoding="utf-8"))
    names = sorted(camera["name"] for camera in facts["cameras"] if camera["name"].startswith(EYE))
    return folder / f"{names[0]}_{POSE}.png" if names else None


def draw_missing(out: Path, jobs: int = 0) -> Iterator[Path]:
    """Draw the picture of each scene in a folder that has none, several at once; yields each path as it is done.

    Args:
        jobs: processes; 0 for one per core.
    Raises:
        CasaError: nothing can be drawn, see run_batch.
    """
    wanted = [eye_picture_of(path.parent) for path in sorted(out.glob(f"*/{SCENE_JSON}"))]
    missing = [path for path in wanted if path is not None and not path.exists()]
    draw = partial(_draw, frame=FRAME)
    for number, _ in run_batch(draw, missing, out, jobs, f"{__name__}:{warm.__name__}", WORKER_BYTES):
        if missing[number].exists():
            yield missing[number]


def _draw(path: Path, frame: PictureSettings) -> None:
    draw_cameras(path.parent, (path.stem.removesuffix(f"_{POSE}"),), frame, POSE)
