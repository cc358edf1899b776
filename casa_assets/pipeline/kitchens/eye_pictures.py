"""Pictures of kitchens at eye level with their doors open, drawn where they are missing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from casa_assets.errors import BatchFault
from casa_assets.pipeline.kitchens.scene_files import EYE_PICTURE, SCENE_JSON
from casa_assets.pipeline.kitchens.scene_folders import EYE_FRAME, OPEN, WORKER_BYTES, draw_cameras
from casa_assets.pipeline.workers.batch import run_batch
from casa_assets.pipeline.workers.limits import WorkerFailure
from casa_assets.preview.photoreal.views import EYE


def missing(out: Path) -> list[Path]:
    """The pictures that the scenes in a folder should have and have not."""
    wanted = [path.with_name(EYE_PICTURE) for path in sorted(out.glob(f"*/{SCENE_JSON}"))]
    return [path for path in wanted if not path.exists()]


def warm() -> None:
    """Nothing but what the import of this module has loaded: pictures need neither the registry nor keys."""


def draw(out: Path, pictures: Sequence[Path], jobs: int = 0) -> Iterator[Path]:
    """Draw pictures of scenes in a folder, several at once; yields each path as it is done.

    Args:
        out: folder of the scenes. pictures: of `missing`. jobs: processes; 0 for one per core.
    Raises:
        CasaError: nothing can be drawn, see run_batch.
        BatchFault: some could not be drawn by a fault of the program; the others are there.
    """
    faults: dict[str, str] = {}
    for number, answer in run_batch(_draw, pictures, out, jobs, f"{__name__}:{warm.__name__}", WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[pictures[number].parent.name] = answer.text
        else:
            yield pictures[number]
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def _draw(path: Path) -> None:
    draw_cameras(path.parent, (EYE,), EYE_FRAME, OPEN)
