"""MJCF file -> compiled model with every warning, compiled once however many checks ask."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco

# Models kept at once: an asset's model and its scene, for a few assets.
KEPT = 8


@dataclass(frozen=True)
class Loaded:
    """Outcome of compiling a file.

    Attributes:
        model: compiled; shared by all callers, so copy before changing it. None if the file does not compile.
        error: MuJoCo's message, empty if it compiles.
        warnings: each once, in the order in which they came.
    """

    model: mujoco.MjModel | None
    error: str
    warnings: tuple[str, ...]


def load_mjcf(path: Path) -> Loaded:
    """Compile an MJCF file; again only if it, or a file in the `meshes` or `textures` next to it, has changed."""
    found = [path, *(f for folder in ("meshes", "textures") for f in sorted((path.parent / folder).glob("*")))]
    stats = [(f.name, f.stat()) for f in found if f.exists()]
    return _load(path, tuple((name, stat.st_mtime_ns, stat.st_size) for name, stat in stats))


def load_asset_file(path: Path) -> Loaded:
    """Compiles any file that MuJoCo reads, without remembering it."""
    with all_warnings() as said:
        try:
            model, error = mujoco.MjModel.from_xml_path(str(path)), ""
        except ValueError as problem:
            model, error = None, " ".join(str(problem).split())
    return Loaded(model, error, tuple(dict.fromkeys(said)))


@contextmanager
def native_warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's own warnings within the block, through its callback.

    Without a listener it prints its warnings, and writes a log into the working folder.
    """
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        yield said
    finally:
        mujoco.set_mju_user_warning(before)


@contextmanager
def all_warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's own warnings and Python's, a line each, once the block has ended."""
    with native_warnings() as said, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            yield said
        finally:
            said[:] = [" ".join(s.split()) for s in (*said, *(str(w.message) for w in caught))]


@lru_cache(maxsize=KEPT)
def _load(path: Path, state: tuple[tuple[str, int, int], ...]) -> Loaded:
    return load_asset_file(path)
