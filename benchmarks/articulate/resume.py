"""What a run over many meshes costs, and whether one that is killed and resumed makes the same bytes.

    ./dev bench articulate_resume FOLDER [--meshes 14] [--jobs 2] [--kill-after 30]

Copies meshes of the folder, each with a comment of its own, so that all bytes differ, and runs `casa-assets articulate`
on them: once without a break, once more over what is done, and then into another library, killed by SIGKILL twice and
resumed. Prints seconds of the clock and of the processor, how many entries each kill left, and the files at which the
two libraries differ.
"""

from __future__ import annotations

import argparse
import filecmp
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def command(meshes: Path, library: Path, jobs: int) -> list[str]:
    """The command line of a run."""
    words = ["articulate", str(meshes), "--library", str(library), "--jobs", str(jobs)]
    return [sys.executable, "-m", "casa_assets.cli.main", *words]


def timed(words: list[str]) -> str:
    """Run a command to its end; the seconds that it took, and the last line but one that counts outcomes."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    counts = [line for line in done.stdout.splitlines() if "accepted," in line]
    return (
        f"{time.monotonic() - begin:6.1f} s, processor {cpu_s:6.1f} s   {counts[-1] if counts else done.stderr[-300:]}"
    )


def killed(words: list[str], after_s: float) -> None:
    """Start a command and kill it with all of its group."""
    running = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    time.sleep(after_s)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()


def entries(library: Path) -> int:
    """How many entries a library has."""
    return sum(1 for name in ("asset.json", "reject.json") for _ in library.glob(f"*/*/{name}"))


def differences(one: Path, other: Path) -> list[str]:
    """Files that are not in both libraries with the same bytes, without the caches."""
    names = [
        {p.relative_to(root) for p in root.rglob("*") if p.is_file() and ".casa" not in p.parts}
        for root in (one, other)
    ]
    both = names[0] & names[1]
    unequal = {name for name in both if not filecmp.cmp(one / name, other / name, shallow=False)}
    return sorted(map(str, (names[0] ^ names[1]) | unequal))


def main() -> None:
    """Run it all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="Folder with meshes.")
    parser.add_argument("--pattern", default="*/input.obj", help="Which of its files are taken.")
    parser.add_argument("--meshes", type=int, default=14)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--kill-after", type=float, default=30.0, help="Seconds of the clock.")
    args = parser.parse_args()
    found = sorted(args.folder.glob(args.pattern))
    if not found:
        parser.error(f"{args.folder} has no {args.pattern}")
    with tempfile.TemporaryDirectory() as place:
        meshes, whole, resumed = (Path(place) / name for name in ("in", "whole", "resumed"))
        meshes.mkdir()
        for number in range(args.meshes):
            path = found[number * max(len(found) // args.meshes, 1) % len(found)]
            text = path.read_bytes()
            (meshes / f"{number:04d}_{path.parent.name}.obj").write_bytes(b"# copy %d\n" % number + text)
        print(f"no break   {timed(command(meshes, whole, args.jobs))}", flush=True)
        print(f"again      {timed(command(meshes, whole, args.jobs))}", flush=True)
        for _ in range(2):
            killed(command(meshes, resumed, args.jobs), args.kill_after)
            print(f"killed     {entries(resumed)} entries", flush=True)
        print(f"resumed    {timed(command(meshes, resumed, args.jobs))}")
        print(f"differ     {differences(whole, resumed) or 'in no file'}")


if __name__ == "__main__":
    main()
