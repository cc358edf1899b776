"""Models of the assets of a library, which its page shows in 3D: script files in a folder beside the page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from casa_assets.errors import BatchFault
from casa_assets.export.gltf import EVERYTHING, asset_glb
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.reports.page_template import relative_link
from casa_assets.pipeline.viewer.model_files import SUFFIX, put_model, put_viewer, viewer_name
from casa_assets.pipeline.workers.batch import run_batch
from casa_assets.pipeline.workers.limits import WorkerFailure

WORKER_BYTES = 1_000_000_000  # of memory, that reading an asset and writing its model may take


@dataclass(frozen=True)
class PageModels:
    """Where a page finds the models of its assets, relative to it: `<folder>/<id>.glb.js`, and the viewer."""

    folder: str
    viewer: str

    @property
    def data(self) -> dict[str, str]:
        """As the script of the page reads it."""
        return {"folder": self.folder, "suffix": SUFFIX, "viewer": self.viewer}


def models_of(target: Path) -> PageModels:
    """Where the page `target` finds its models."""
    folder = relative_link(folder_of(target).name)
    return PageModels(folder, f"{folder}/{viewer_name()}")


def folder_of(target: Path) -> Path:
    """Folder of the models of a page, such as `report_models` beside `report.html`."""
    return target.with_name(f"{target.stem}_models")


def write_models(root: Path, target: Path, jobs: int = 0) -> Iterator[tuple[int, int]]:
    """Write the models that are missing; yields (how many there are, of how many) as they are done.

    The id of an asset is a digest of what it is, so a model that is there is not made again. Those of assets that are
    gone are removed.

    Args:
        root: of the library. target: the page. jobs: processes; 0: one per core.
    Raises:
        BatchFault: some could not be made; the others are there.
    """
    folder = folder_of(target)
    put_viewer(folder)
    folders = {path.name: path for path in disk.Library(root).accepted()}
    for old in folder.glob(f"*{SUFFIX}"):
        if old.name.removesuffix(SUFFIX) not in folders:
            old.unlink()
    missing = [path for name, path in folders.items() if not (folder / f"{name}{SUFFIX}").is_file()]
    done = len(folders) - len(missing)
    yield done, len(folders)
    faults: dict[str, str] = {}
    work = partial(_write_model, folder=folder)
    for number, answer in run_batch(work, missing, folder, jobs, f"{__name__}:warm", WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[missing[number].name] = answer.text
        done += 1
        yield done, len(folders)
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def _write_model(path: Path, folder: Path) -> str:
    """The model of the asset in a folder of a library."""
    asset = disk.read_asset(path)
    return put_model(folder, asset.id, asset_glb(asset, EVERYTHING))


def warm() -> None:
    """Nothing: all that a worker needs is loaded with this module."""
