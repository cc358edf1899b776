"""Models of the assets of a library, which its page shows in 3D: script files in a folder next to the page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from urllib.parse import quote

from casa_assets.cache.cache_key import key_of
from casa_assets.errors import BatchFault
from casa_assets.formats.gltf import asset_glb
from casa_assets.library import library as disk
from casa_assets.runs.engine import run_batch
from casa_assets.runs.limits import WorkerFailure
from casa_assets.show.page.page_template import SUFFIX, ModelFiles, put_model, put_viewer, viewer_name

MADE_BY = "made_by.txt"
WORKER_BYTES = 1_000_000_000  # of memory, that reading an asset and writing its model may take


@dataclass(frozen=True)
class PageModels:
    """Where a page finds the models of its assets, relative to it: `<folder>/<id>.glb.js`, and the viewer."""

    folder: str
    viewer: str

    def of(self, asset_id: str) -> ModelFiles:
        """Return the files with which the page shows the model of an asset."""
        return ModelFiles(asset_id, f"{self.folder}/{asset_id}{SUFFIX}", self.viewer)

    @property
    def data(self) -> dict[str, str]:
        """As the script of the page reads it."""
        return {"folder": self.folder, "suffix": SUFFIX, "viewer": self.viewer}


def models_of(target: Path) -> PageModels:
    """Where the page `target` finds its models."""
    folder = f"./{quote(folder_of(target).name)}"
    return PageModels(folder, f"{folder}/{viewer_name()}")


def folder_of(target: Path) -> Path:
    """Return the folder of the models of a page, such as `report_models` next to `report.html`."""
    return target.with_name(f"{target.stem}_models")


def write_models(root: Path, target: Path, jobs: int = 0) -> Iterator[tuple[int, int]]:
    """Write the models of the assets of a library that are missing; yields (how many there are, of how many).

    A model is made again where its asset was written after it, by a correction for instance, and all are where the
    code that makes them has changed. Those of assets that are gone are removed.

    Args:
        root: of the library. target: the page. jobs: processes; 0: one per core.
    Raises:
        BatchFault: some could not be made; the others are there.
    """
    folder = folder_of(target)
    _empty_unless_made_by(key_of(asset_glb, put_viewer), folder)
    put_viewer(folder)
    folders = {path.name: path for path in disk.Library(root).accepted()}
    for old in folder.glob(f"*{SUFFIX}"):
        if old.name.removesuffix(SUFFIX) not in folders:
            old.unlink()
    missing = []
    for name, path in folders.items():
        model = folder / f"{name}{SUFFIX}"
        if not model.is_file() or model.stat().st_mtime_ns <= (path / disk.CERTIFICATE).stat().st_mtime_ns:
            missing.append(path)
    done = len(folders) - len(missing)
    yield done, len(folders)
    faults: dict[str, str] = {}
    work = partial(_write_model, folder=folder)
    for number, answer in run_batch(work, missing, folder, jobs, warm, WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[missing[number].name] = answer.text
        done += 1
        yield done, len(folders)
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def _empty_unless_made_by(key: str, folder: Path) -> None:
    """Remove models and viewers that other code has made; the folder keeps the key of the code that fills it."""
    mark = folder / MADE_BY
    if mark.is_file() and mark.read_text(encoding="utf-8") == key:
        return
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.js"):
        old.unlink()
    mark.write_text(key, encoding="utf-8")


def _write_model(path: Path, folder: Path) -> str:
    asset = disk.read_asset(path)
    return put_model(folder, asset.id, asset_glb(asset, with_layers=True))


def warm() -> None:
    """Nothing: all that a worker needs is loaded with this module."""
