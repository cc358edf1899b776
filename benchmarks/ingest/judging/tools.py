"""The tools that are compared: each takes an Input and answers with its shapes, or says why there are none."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from benchmarks.ingest.judging import shapes
from benchmarks.ingest.judging.inputs import Input, write_obj
from casa_assets.errors import CasaError
from casa_assets.geometry.solid.solids import convex_hull, hull_volume
from casa_assets.ingest.collision.convex_decomposition import Budget, DecompositionFailed, decompose
from casa_assets.pipeline.ingest.job import Event
from casa_assets.pipeline.ingest.run import Options, ingest
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.reports.entry import entries

PEER = "obj2mjcf"
PEER_VERSION = "0.0.25"
# scipy: trimesh, which the peer reads meshes with, does not say that it needs it.
PEER_PACKAGES = (f"{PEER}=={PEER_VERSION}", "scipy", "networkx")
WATER = 1000.0  # MuJoCo's density where a file says nothing, kg/m^3


@dataclass(frozen=True)
class Answer:
    """What a tool made of an input: shapes and the density that it meant, or None and why; seconds that it took."""

    seconds: float
    shapes: shapes.Shapes | None = None
    density: float = WATER
    message: str = ""


Tool = Callable[[Input], Answer]


@dataclass(frozen=True)
class Verdict:
    """What our pipeline made of one input: its category, seconds, and model.xml or the reason why there is none."""

    category: str
    seconds: float
    model: Path | None
    message: str


def ingested(folder: Path, out: Path, limit_s: float) -> dict[str, Verdict]:
    """casa_assets on every input, one at a time, into a fresh library: path -> verdict.

    The time of an input is that since the one before it was done with; the first also bears the start of the workers.
    """
    shutil.rmtree(out, ignore_errors=True)
    took: dict[str, tuple[Event, float]] = {}
    before = time.monotonic()
    for event in ingest([folder], Options(library=out, jobs=1, seconds=limit_s)):
        took[event.path] = (event, time.monotonic() - before)
        before = time.monotonic()
    known = {entry.id: entry for entry in entries(Library(out))}
    verdicts = {}
    for path, (event, seconds) in took.items():
        entry = known[event.asset_id]
        model = out / entry.path / "model.xml" if entry.accepted else None
        verdicts[path] = Verdict(entry.category, seconds, model, f"{event.code} {event.message}".strip())
    return verdicts


def ours(verdicts: Mapping[str, Verdict]) -> Tool:
    """casa_assets from the raw file to a published folder: MJCF, USD, picture and every check."""

    def run(item: Input) -> Answer:
        verdict = verdicts[item.path]
        if verdict.model is None:
            return Answer(verdict.seconds, message=verdict.message)
        return Answer(verdict.seconds, shapes.of_model(verdict.model), item.density)

    return run


def peer(venv: Path, out: Path, limit_s: float) -> Tool:
    """obj2mjcf with --decompose, one process per mesh; it is handed the mesh cleaned, upright and in metres."""
    shutil.rmtree(out, ignore_errors=True)

    def run(item: Input) -> Answer:
        if item.mesh is None:
            return Answer(0.0, message="there is no mesh to hand over")
        name = f"mesh_{len(list(out.glob('*'))):04d}" if out.is_dir() else "mesh_0000"
        write_obj(item.mesh, out / name / f"{name}.obj")
        command = [str(venv / "bin" / PEER), "--obj-dir", str(out / name), "--save-mjcf", "--decompose", "--overwrite"]
        begin = time.monotonic()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s, check=False)
        except subprocess.TimeoutExpired:
            return Answer(time.monotonic() - begin, message=f"still running after {limit_s:g} s and was stopped")
        seconds = time.monotonic() - begin
        model = out / name / name / f"{name}.xml"
        if not model.is_file():
            words = (done.stderr or done.stdout).strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
            return Answer(seconds, message=f"wrote no model: {words[0][:120]}")
        try:
            return Answer(seconds, shapes.of_model(model))
        except ValueError as error:
            return Answer(seconds, message=f"its model does not compile: {str(error).splitlines()[0][:120]}")

    return run


def one_hull(item: Input) -> Answer:
    """The convex hull of everything."""
    if item.mesh is None:
        return Answer(0.0, message="there is no mesh")
    begin = time.monotonic()
    try:
        cloud, _ = convex_hull(item.mesh[0])
    except CasaError as error:
        return Answer(time.monotonic() - begin, message=str(error))
    seconds = time.monotonic() - begin
    return Answer(seconds, shapes.of_clouds([cloud], WATER))


def vhacd(item: Input) -> Answer:
    """V-HACD of everything at once: 32 hulls of 64 vertices, 400,000 voxels."""
    if item.mesh is None:
        return Answer(0.0, message="there is no mesh")
    begin = time.monotonic()
    try:
        clouds = decompose("vhacd", *item.mesh, Budget(hulls=32, hull_vertices=64))
        seconds = time.monotonic() - begin
        return Answer(seconds, shapes.of_clouds([c for c in clouds if hull_volume(c) > 0], WATER))
    except (DecompositionFailed, CasaError) as error:
        return Answer(time.monotonic() - begin, message=str(error))


def install_peer(venv: Path) -> str:
    """Make an environment of the peer's own; empty where it is there, else why it is not."""
    if (venv / "bin" / PEER).is_file():
        return ""
    print(f"installing {PEER} {PEER_VERSION} into {venv} (once, needs a package index) ...", file=sys.stderr)
    subprocess.run([sys.executable, "-m", "venv", "--clear", str(venv)], check=True)
    command = [str(venv / "bin" / "python"), "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    done = subprocess.run([*command, *PEER_PACKAGES], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return ""
    words = done.stderr.strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
    return f"{PEER} {PEER_VERSION} could not be installed: {words[0]}"
