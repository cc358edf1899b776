"""Pictures of kitchens at the height of eyes with their doors open, drawn where they are missing."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from casa_assets.errors import BatchFault
from casa_assets.pipeline.kitchens.scene_files import SCENE_JSON
from casa_assets.pipeline.kitchens.scene_folders import WORKER_BYTES, draw_cameras, warm
from casa_assets.pipeline.workers.batch import run_batch
from casa_assets.pipeline.workers.limits import WorkerFailure
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


def missing(out: Path) -> list[Path]:
    """The pictures that the scenes in a folder should have and have not."""
    wanted = [eye_picture_of(path.parent) for path in sorted(out.glob(f"*/{SCENE_JSON}"))]
    return [path for path in wanted if path is not None and not path.exists()]


def draw(out: Path, pictures: Sequence[Path], jobs: int = 0) -> Iterator[Path]:
    """Draw pictures of scenes in a folder, several at once; yields each path as it is done.

    Args:
        out: folder of the scenes. pictures: of `missing`. jobs: processes; 0 for one per core.
    Raises:
        CasaError: nothing can be drawn, see run_batch.
        BatchFault: some could not be drawn by a fault of the program; the others are there.
    """
    faults: dict[str, str] = {}
    work = partial(_draw, frame=FRAME)
    for number, answer in run_batch(work, pictures, out, jobs, f"{__name__}:{warm.__name__}", WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[pictures[number].parent.name] = answer.text
        else:
            yield pictures[number]
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def _draw(path: Path, frame: PictureSettings) -> None:
    draw_cameras(path.parent, (path.stem.removesuffix(f"_{POSE}"),), frame, POSE)
