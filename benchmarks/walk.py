"""The files of casa_assets that code runs through on a way from the Python API to a finished asset, in their order.

    ./dev walk mug            a mesh: casa.ingest of examples/meshes/mug.obj into a library, to its certificate
    ./dev walk kitchen        a plan and a style: casa.kitchen("l_small", "coastal", seed=7).write()
    ./dev walk microwave      a static appliance: casa.articulate of the mesh of a microwave
    ./dev walk kettle         a member of a family: casa.build("kettle").write()
    ./dev walk                the numbers of all three, with what earlier runs left in the cache and without

Each file is printed when one of its functions is called for the first time, with the number of functions that run in it
and the first sentence of its docstring. Workers run in this process, so that what they do is seen. Registry, textures
and built assets come from a cache that an unmeasured first run has filled, as on the machine of somebody who works with
it; with --cold all of them are made. The output folder is new in either case.
"""

from __future__ import annotations

import argparse
import ast
import inspect
import itertools
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import Any

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "casa_assets"
MESHES = ROOT / "examples" / "meshes"


def mug(out: Path) -> None:
    """A mesh into a library."""
    import casa_assets as casa

    done = casa.ingest(MESHES / "mug.obj", library=out / "library")
    print(done.folder, file=sys.stderr)


def kitchen(out: Path) -> None:
    """A plan in a style, written."""
    import casa_assets as casa

    print(casa.kitchen("l_small", "coastal", seed=7).write(out / "scenes"), file=sys.stderr)


def microwave(out: Path) -> None:
    """A static appliance that is given joints."""
    import casa_assets as casa

    done = casa.articulate(MESHES.parent / "appliances" / "microwave.obj", library=out / "library")
    print(done.folder, file=sys.stderr)


def kettle(out: Path) -> None:
    """A member of a family becomes an asset."""
    import casa_assets as casa

    print(casa.build("kettle").write(out / "assets"), file=sys.stderr)


WALKS: dict[str, Callable[[Path], None]] = {"mug": mug, "kitchen": kitchen, "microwave": microwave, "kettle": kettle}


class Steps:
    """Files in the order in which code enters them, with the functions that run in each."""

    def __init__(self) -> None:
        self.functions: dict[str, set[tuple[str, int]]] = {}
        self._inside = str(PACKAGE) + "/"

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        """A profile function: notes calls of functions; bodies of modules and of classes are no calls."""
        code = frame.f_code
        is_function = code.co_flags & inspect.CO_OPTIMIZED and not code.co_name.startswith("<")
        if event == "call" and is_function and code.co_filename.startswith(self._inside):
            self.functions.setdefault(code.co_filename, set()).add((code.co_name, code.co_firstlineno))


@contextmanager
def in_this_process() -> Iterator[None]:
    """Let the pool call its functions here, one after the other."""
    from casa_assets.runs.pool import Pool, Step, address_of

    def called(function: Step) -> Callable[..., Any]:
        module, _, name = address_of(function).partition(":")
        return getattr(import_module(module), name)  # type: ignore[no-any-return]

    def run(
        _: Pool, function: Step, jobs: Sequence[Any], started: Callable[[int], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        for number, job in enumerate(jobs):
            if started is not None:
                started(number)
            yield number, called(function)(job)

    def prepare(_: Pool, warm: Step) -> None:
        called(warm)()

    kept = Pool.run, Pool.prepare
    Pool.run, Pool.prepare = run, prepare  # type: ignore[method-assign]
    try:
        yield
    finally:
        Pool.run, Pool.prepare = kept  # type: ignore[method-assign]


def walked(walk: Callable[[Path], None]) -> dict[str, int]:
    """Paths of the files that a walk enters, in order, with the number of functions that run in each."""
    steps = Steps()
    with tempfile.TemporaryDirectory() as folder, in_this_process():
        sys.setprofile(steps)
        try:
            walk(Path(folder))
        finally:
            sys.setprofile(None)
    return {str(Path(path).relative_to(ROOT)): len(found) for path, found in steps.functions.items()}


def sentence(path: Path) -> str:
    """The first sentence of a module's docstring."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return text.partition("\n\n")[0].replace("\n", " ")


def main() -> None:
    """Print one walk, or the numbers of all."""
    parser = argparse.ArgumentParser(
        prog="./dev walk", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("walk", choices=sorted(WALKS), nargs="?", help="which; without it: the numbers of all")
    parser.add_argument("--cold", action="store_true", help="begin with an empty cache")
    arguments = parser.parse_args()
    if arguments.walk is None:
        for name, words in itertools.product(WALKS, ((), ("--cold",))):
            command = (sys.executable, "-m", "benchmarks.walk", name, *words)
            done = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
            print(done.stdout.splitlines()[-1], flush=True)
        return
    with tempfile.TemporaryDirectory() as folder:
        os.environ["CASA_ASSETS_CACHE"] = f"{folder}/cache"  # read when the package is first used, below
        if not arguments.cold:
            WALKS[arguments.walk](Path(folder))
        files = walked(WALKS[arguments.walk])
    for number, (path, functions) in enumerate(files.items(), 1):
        print(f"{number:4} {path} ({functions}): {sentence(ROOT / path)}")
    lines = sum((ROOT / path).read_text(encoding="utf-8").count("\n") for path in files)
    folders = len({Path(path).parent for path in files})
    cache = "empty cache" if arguments.cold else "filled cache"
    sums = f"{len(files)} files with {lines:,} lines in {folders} folders, {sum(files.values()):,} functions"
    print(f"{arguments.walk}, {cache}: {sums}")


if __name__ == "__main__":
    main()
