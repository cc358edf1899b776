"""A set of defective and hostile inputs through `casa-assets ingest`, each held against what its index expects.

    ./dev bench hostile_input ../shared/data/bad [--memory 2] [--faces]

Prints every input that did not end as its index says, what any process touched beyond its folders, the most memory of
the program itself, and seconds; writes out/bench/hostile_input.md with all rows. With --faces also a mesh of two
million faces, with seconds and the most memory of a worker. Exit 1 where something is not as it should be.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.access_audit import Watch
from tests.hostile_set import HostileSet, Said, disputed, told, verdict
from tests.libraries import casa

ROOT = Path(__file__).resolve().parents[1]


def main() -> int:
    """Run the set and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--memory", default="2")
    parser.add_argument("--faces", action="store_true")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        work = Path(place)
        watch = Watch(work / "watch")
        hostile = HostileSet(asked.folder, work / "bad", ("--memory", asked.memory), watch.environment)
        begin = time.monotonic()
        hostile.run()
        special = hostile.special()
        seconds = time.monotonic() - begin
        wrong = _table(hostile, special, asked.out)
        escapes = watch.escapes([hostile.work], list(hostile.libraries()))
        peak = max(watch.peaks("casa_assets/cli/main.py"))
        print(f"{len(hostile.rows)} inputs, {len(wrong)} not as expected (target 0); {seconds:.0f} s")
        print(f"beyond the folders: {len(escapes)} (target 0)", *escapes[:20], sep="\n  ")
        print(f"most memory of the program itself: {peak / 1e6:.0f} MB")
        if asked.faces:
            _faces(asked.folder, work)
    return 1 if wrong or escapes else 0


def _table(hostile: HostileSet, special: list[Said], out: Path) -> list[str]:
    lines = ["| input | expected | became | |", "|---|---|---|---|"]
    wrong = []
    for row in hostile.rows:
        said = hostile.said.get(row.file, [])
        bad = verdict(row, said)
        why = disputed(row, bad) if bad else ""
        words = "; ".join(map(told, said)).replace("|", "/")
        mark = why or ("MISS" if bad else "pass")
        lines.append(f"| `{row.path.strip()[:60]}` | {' / '.join(row.wanted)} | {words} | {mark} |")
        if why:
            print(f"disputed {row.path[:70]}: {bad}; {why}")
        elif bad:
            wrong.append(row.file)
            print(f"MISS {row.path[:70]}: wanted {' | '.join(row.wanted)}; {bad}")
    lines += [f"| `special/{one.path}` | | {told(one)} | |" for one in special]
    out.mkdir(parents=True, exist_ok=True)
    (out / "hostile_input.md").write_text("\n".join(lines) + "\n", encoding="utf-8", errors="backslashreplace")
    return wrong


def _faces(folder: Path, work: Path) -> None:
    mesh = work / "mug_2m_faces.stl"
    subprocess.run([sys.executable, str(folder / "gen_2m_faces.py"), str(mesh)], check=True, stdout=subprocess.DEVNULL)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    done = casa("ingest", mesh, "--library", work / "faces", "--json")
    seconds = time.monotonic() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    (said,) = [Said.of(json.loads(line)) for line in done.stdout.splitlines()]
    print(f"two million faces: {told(said)}; {seconds:.0f} s, {processor:.0f} s of processor time,", end=" ")
    print(f"{after.ru_maxrss / 1e6:.2f} GB in the largest process")


if __name__ == "__main__":
    sys.exit(main())
