"""Cheap inputs for whole runs, the program as a process and in this one, and libraries as plain data."""

from __future__ import annotations

import fcntl
import importlib
import io
import json
import os
import pickle
import shutil
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any, Self
from unittest.mock import patch

from casa_assets.cli import main as program
from casa_assets.ingest.run import inputs
from casa_assets.library import entry_table
from casa_assets.model.record import Vec3
from casa_assets.runs import pool
from casa_assets.runs.limits import WorkerFailure
from tests.support.mesh.meshes import box_mesh

ROOT = Path(__file__).parents[3]
BOXES: dict[str, Vec3] = {
    "cereal_box": (0.19, 0.29, 0.06),
    "cutting_board": (0.36, 0.018, 0.24),
    "milk_carton": (0.07, 0.24, 0.07),
}
CUT_GLB = b"glTF\x02\0\0\0\xff\0\0\0"


def box_obj(size: Vec3) -> str:
    """OBJ text of a box, y up, standing on the ground; metres."""
    mesh = box_mesh(size, (0.0, size[1] / 2, 0.0), shared=True)
    rows = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in mesh.vertices]
    rows += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.faces]
    return "\n".join(rows) + "\n"


def write_files(folder: Path, texts: Mapping[str, str]) -> Path:
    """A folder with files of some texts, by their names in it."""
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@contextmanager
def edited(path: Path) -> Iterator[Any]:
    """The JSON in a file, which is written anew with what is changed in it."""
    data = json.loads(path.read_text(encoding="utf-8"))
    yield data
    path.write_text(json.dumps(data), encoding="utf-8")


def put_boxes(folder: Path, *names: str) -> Path:
    """A folder with some of the boxes, or all, as `<name>.obj`."""
    return write_files(folder, {f"{name}.obj": box_obj(BOXES[name]) for name in names or BOXES})


def make_inputs(folder: Path) -> Path:
    """Three boxes that are accepted, one file that is cut, one twin, one row of a manifest without a file."""
    put_boxes(folder)
    (folder / "broken.glb").write_bytes(CUT_GLB)
    rows = '{"id": "a", "file": "gone_a.glb"}\n{"id": "b", "file": "gone_b.glb"}\n'
    return write_files(folder, {"twin.obj": box_obj(BOXES["cereal_box"]), "manifest.jsonl": rows})


def made_once(common: Path, name: str, make: Callable[[Path], object]) -> Path:
    """A folder that all processes of a run of the tests read and none changes; the first that asks makes it.

    Args:
        common: what these processes have in common. make: is given a folder that is not there yet.
    """
    place, draft = common / name, common / f"{name}_draft"
    with (common / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not place.exists():
            shutil.rmtree(draft, ignore_errors=True)
            make(draft)
            draft.rename(place)
    return place


def make_boxes(folder: Path) -> None:
    """`in`: inputs of `make_inputs`; `library`: of them, by one worker, hash seed 0; `lines.jsonl`: what it printed."""
    make_inputs(folder / "in")
    words = ("ingest", folder / "in", "--library", folder / "library", "--jobs", 1, "--json")
    done = casa(*words, code=1, PYTHONHASHSEED="0")
    (folder / "lines.jsonl").write_text(done.stdout, encoding="utf-8")


def make_few(folder: Path) -> None:
    """`in`: two boxes and a file that is cut; `library`: of them, by one worker."""
    (put_boxes(folder / "in", "cereal_box", "milk_carton") / "broken.glb").write_bytes(CUT_GLB)
    done = casa_here("ingest", folder / "in", "--library", folder / "library", "--jobs", 1)
    assert done.returncode == 1, done.stdout + done.stderr


def input_rows(printed: str) -> list[dict[str, Any]]:
    """Rows of `ingest --json` that are about inputs, not about the files that are no meshes."""
    rows: list[dict[str, Any]] = [json.loads(line) for line in printed.splitlines()]
    return [row for row in rows if row["status"] != "no_mesh"]


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "casa_assets.cli.main", *map(str, arguments)]


def ran(*words: object, code: int | None = 0, **options: Any) -> subprocess.CompletedProcess[str]:
    """A command that has ended, with this code (None: with any). options: of `subprocess.run`."""
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False, **options)
    assert code in (None, done.returncode), f"{words}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    return done


def casa(*arguments: object, code: int | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    variables = {**os.environ, "COLUMNS": "200", **environment}
    return ran(*command(*arguments), code=code, cwd=ROOT, env=variables, errors="surrogateescape")


def hooked(hook: str, folder: Path, *arguments: object, **environment: str) -> subprocess.Popen[str]:
    """Start the program with code that it and its workers run when they begin, written into a folder."""
    (folder / "sitecustomize.py").write_text(hook, encoding="utf-8")
    path = f"{folder}:{os.environ.get('PYTHONPATH', ROOT)}"
    return subprocess.Popen(
        command(*arguments),
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": path, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def casa_here(*arguments: object, **environment: str) -> subprocess.CompletedProcess[str]:
    """As `casa`, in this process and in seconds less: without its signals and its end by the system."""
    words = [str(word) for word in arguments]
    streams = [io.TextIOWrapper(io.BytesIO(), "utf-8", "backslashreplace", write_through=True) for _ in range(2)]
    with (
        patch.dict(os.environ, {"COLUMNS": "200", **environment}),
        patch.object(sys, "argv", ["casa-assets", *words]),
        redirect_stdout(streams[0]),
        redirect_stderr(streams[1]),
    ):
        code = program._run_app()
    out, errors = (stream.buffer.getvalue().decode() for stream in streams)
    return subprocess.CompletedProcess(words, code, out, errors)


class Here:
    """Runs the jobs of a run one after the other in this process, without limits; see pool.Engine."""

    def __init__(self, *_: Any) -> None:
        pass

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def prepare(self, warm: pool.Step) -> None:
        """Nothing is loaded before the first job asks for it."""

    def run(
        self, function: pool.Step, jobs: Sequence[Any], started: Callable[[int], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """Yield (number of the job, answer or WorkerFailure); jobs and answers are pickled, as between processes."""
        module, name = pool.address_of(function).split(":")
        for number, job in enumerate(jobs):
            if started is not None:
                started(number)
            try:
                answer = getattr(importlib.import_module(module), name)(pickle.loads(pickle.dumps(job)))
            except Exception as error:  # noqa: BLE001  as in a worker
                answer = WorkerFailure("error", f"{type(error).__name__}: {error}", traceback.format_exc())
            yield number, pickle.loads(pickle.dumps(answer))


@contextmanager
def no_workers() -> Iterator[None]:
    with patch.object(pool, "Pool", Here):
        yield


def called(*arguments: object, folder: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    """As `casa_here`, without workers; in a folder."""
    with no_workers(), chdir(folder):
        return casa_here(*arguments, **environment)


def limited(kilobytes: int, *arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the program where no file may become larger, which stands for a disk that is full.

    It keeps no compiled modules: Python 3.11 would put one that was cut off at that size into the package, and whoever
    imports it next would fail.
    """
    words = ["bash", "-c", f'ulimit -f {kilobytes}; exec "$@"', "bash", *command(*arguments)]
    return ran(*words, code=None, cwd=ROOT, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})


def tree(root: Path) -> dict[str, bytes | None]:
    """Relative path -> bytes of every file below a folder; None for a folder.

    The tables of entries and inputs in the cache are left out: they tell when files were written, and are no output.
    """
    return {
        path.relative_to(root).as_posix(): None if path.is_dir() else path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.name not in (entry_table.NAME, inputs.SURVEYS)
    }


def differences(one: Path, other: Path) -> list[str]:
    a, b = tree(one), tree(other)
    return sorted(path for path in a.keys() | b.keys() if path not in a or path not in b or a[path] != b[path])


def entries_of(library: Path) -> Sequence[str]:
    found = [*library.glob("*/*/asset.json"), *library.glob("rejected/*/reject.json")]
    return sorted(path.parent.relative_to(library).as_posix() for path in found)
