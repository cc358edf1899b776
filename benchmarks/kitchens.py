"""Our kitchens and those of scene_synthesizer 1.15.0 in the same run: how fast made, loaded and stepped, what opens.

    ./dev bench kitchens                            l_small__coastal, galley__coastal and the peer's six templates
    ./dev bench kitchens u_small__rustic --no-peer  one of ours alone

Writes out/bench/kitchens.json and .md, and prints the latter. `make`: seconds from names to the scene in memory;
`write`: MJCF and USD to files (light: its MJCF); both with what earlier runs painted at hand, and without the import of
the program, which the JSON has. `check`: every check of a scene, on one core, the files made. `load`: seconds of MuJoCo
in a fresh process, the best of three; `3.3.7` of the oldest that we support, where `./dev consumers` has made its
environment. `awake`, `at work`, `asleep`: times real time of one core at steps of 2 ms with ten boxes and balls dropped
in, after a second in which they settle, by the seconds of the process. Awake, everything is computed all the time; at
work, MuJoCo 4 may let sleep what is at rest while two doors and one loose thing are pushed; asleep, nothing is. `bare`
leaves out what a kitchen of ours itself has standing loose on its worktops, for the peer's are empty; it is what the
targets of ten loose things are held against. `clash`: joints that run more than 5 mm into another object when each is
opened alone; of the full form. The last row of ours has the ten things alone, on a floor.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import venv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
TOOLS = ROOT / "benchmarks" / "rooms"
OUT = ROOT / "out" / "bench"
SCENES = OUT / "kitchens"
OURS = ("l_small__coastal", "galley__coastal")
OLD = ROOT / ".venv-mujoco337" / "bin" / "python"
PEER_VENV, PEER = ROOT / ".venv-scenesynth", "scene-synthesizer[recommend]==1.15.0"
SHAPES = ("single_wall", "galley", "l_shaped", "u_shaped", "peninsula", "island")
# What we hold ourselves to: seconds at most, or times real time at least.
TARGETS = {
    "make + write": 3.0,
    "check": 20.0,
    "load": 1.0,
    "load in 3.3.7": 1.0,
    "full, at work": 20.0,
    "light, at work": 60.0,
    "full, awake": 20.0,
    "light, awake": 60.0,
}
AT_MOST = ("make + write", "check", "load", "load in 3.3.7")
HEADS = (
    "kitchen",
    "make s",
    "write s",
    "check s",
    "load s",
    "3.3.7",
    "bodies",
    "joints",
    "geoms",
    "awake",
    "at work",
    "asleep",
    "awake steps/s",
    "clash",
)
# What the ten loose things cost by themselves, which no kitchen around them can be faster than.
FLOOR = """
<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody>
<geom type="box" size="1 1 .1" pos="-1 -1 -.1"/><geom type="box" size="1 1 .1" pos="1 -1 -.1"/>
<geom type="box" size="1 1 .1" pos="-1 1 -.1"/><geom type="box" size="1 1 .1" pos="1 1 -.1"/>
</worldbody></mujoco>
"""
LOAD = """
import sys, time
import mujoco
begin = time.perf_counter()
mujoco.MjModel.from_xml_path(sys.argv[1])
print(time.perf_counter() - begin)
"""
Row = dict[str, Any]


def main() -> int:
    """Measure both sides, print, and write down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=OURS, help="ids of ours")
    parser.add_argument("--templates", nargs="*", default=SHAPES, help="of the peer")
    parser.add_argument("--seeds", type=int, default=1, help="of each template")
    parser.add_argument("--no-peer", action="store_true")
    options = parser.parse_args()
    SCENES.mkdir(parents=True, exist_ok=True)
    rows = [row for scene in options.scenes for row in ours(scene)] + [empty_floor()]
    if not options.no_peer:
        python = peer_python()
        rows += [peer(python, name, seed) for name in options.templates for seed in range(options.seeds)]
    text = page(rows)
    (OUT / "kitchens.json").write_text(
        json.dumps({"machine": machine(), "rows": rows}, indent=1) + "\n", encoding="utf-8"
    )
    (OUT / "kitchens.md").write_text(text, encoding="utf-8")
    print(text)
    return 0


def run(command: Sequence[str | Path]) -> Any:
    """What a program says as its last line, read as JSON; one thread, so that all are alike."""
    told = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run([str(c) for c in command], cwd=ROOT, env=told, check=False, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def ours(scene: str) -> list[Row]:
    """A kitchen of ours, in both weights, with and without what stands loose in it."""
    scenes = [Path(sys.executable).with_name("casa-assets"), "scenes"]
    there = ["--out", SCENES, "--no-pictures", "--jobs", "1"]
    subprocess.run([str(c) for c in (*scenes, "build", scene, *there)], check=True, cwd=ROOT)
    check_s = run([*scenes, "check", scene, "--force", "--json", *there])["check_s"]
    made = run([sys.executable, TOOLS / "ours.py", scene, SCENES])
    write_s = made["mjcf_s"] + made["usd_s"]
    rows = []
    for weight, file in (("full", "scene.xml"), ("light", "scene_light.xml")):
        path = SCENES / scene / file
        seconds = {"make_s": made["generate_s"], "write_s": write_s if weight == "full" else made["light_s"]}
        base = {"kitchen": f"{scene}, {weight}", "import_s": made["import_s"], "check_s": check_s, **seconds}
        loads = {"load_s": load_seconds(sys.executable, path), "load_old_s": load_seconds(OLD, path)}
        # The light form is the same machine, but has no fixtures left to tell one's own parts from another's.
        found = run([sys.executable, TOOLS / "measure.py", path, *(["--pace"] if weight == "light" else [])])
        rows.append({**base, **found, **loads})
        bare = run(measure(sys.executable, path, "--bare"))
        rows.append({**base, "kitchen": f"{scene}, {weight}, bare", **bare, **loads})
    return rows


def empty_floor() -> Row:
    """The loose things on a floor without a kitchen."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "floor.xml"
        path.write_text(FLOOR, encoding="utf-8")
        return {"kitchen": "none, an empty floor", **run(measure(sys.executable, path))}


def load_seconds(python: str | Path, path: Path) -> float | None:
    """Of MuJoCo in a fresh process, the best of three; None where there is no such interpreter."""
    if not Path(python).is_file():
        return None
    return min(float(run([python, "-c", LOAD, path])) for _ in range(3))


def measure(python: str | Path, path: Path, *more: str) -> list[str | Path]:
    """The command that measures the pace of a file."""
    return [python, TOOLS / "measure.py", path, "--pace", *more]


def peer_python() -> Path:
    """The interpreter of the peer's own environment, which is made where it is missing."""
    python, stamp = PEER_VENV / "bin" / "python", PEER_VENV / ".stamp"
    held = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    wanted = [PEER, *(line for line in held if line.startswith(("mujoco==", "numpy==")))]
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != "\n".join(wanted):
        print(f"Installing {PEER} into {PEER_VENV.name} (once) ...", file=sys.stderr)
        if not python.is_file():
            venv.create(PEER_VENV, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-qq", *wanted], check=True)
        stamp.write_text("\n".join(wanted), encoding="utf-8")
    return python


def peer(python: Path, template: str, seed: int) -> Row:
    """A kitchen of the peer; USD alone is its other format, so URDF and USD are what it writes."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        made = run([python, TOOLS / "peer.py", f"kitchen_{template}", str(seed), place])
        # MuJoCo is ours on both sides; the peer's files need nothing of it.
        found = run(measure(sys.executable, place / "kitchen.urdf"))
        found["load_s"] = load_seconds(sys.executable, place / "kitchen.urdf")
        found["load_old_s"] = load_seconds(OLD, place / "kitchen.urdf")
        swept = run([sys.executable, TOOLS / "measure.py", place / "apart.urdf", "--sweep", place / "objects.json"])
    seconds = {"import_s": made["import_s"], "make_s": made["generate_s"], "write_s": made["urdf_s"] + made["usd_s"]}
    return {"kitchen": f"peer {template} {seed}", **seconds, **found, "clashes": swept}


def page(rows: Sequence[Row]) -> str:
    """The rows as a table, and what we hold ourselves to."""
    cells = [_cells(row) for row in rows]
    lines = [f"| {' | '.join(HEADS)} |", f"|{'---|' * len(HEADS)}", *(f"| {' | '.join(c)} |" for c in cells), ""]
    for what, limit, values in _held(rows):
        worst = max(values) if what in AT_MOST else min(values)
        good = worst <= limit if what in AT_MOST else worst >= limit
        lines.append(f"- {what}: worst {worst:.2f}, target {limit:g}: {'held' if good else 'MISSED'}")
    return "\n".join([f"{machine()}", "", *lines, ""])


def _cells(row: Row) -> list[str]:
    awake, swept = row["awake"], row.get("clashes")
    return [
        row["kitchen"],
        *(_seconds(row, name) for name in ("make_s", "write_s", "check_s", "load_s", "load_old_s")),
        *(f"{row[name]}" for name in ("bodies", "joints", "geoms")),
        *(f"{row[how]['real_time']:.1f}" if row[how] else "" for how in ("awake", "stirred", "asleep")),
        f"{awake['steps_per_s']:,.0f}",
        f"{swept['clash']} of {swept['joints']}" if swept else "",
    ]


def _seconds(row: Row, name: str) -> str:
    """A duration as text; nothing where there is none."""
    return "" if row.get(name) is None else f"{row[name]:.2f}"


def _held(rows: Sequence[Row]) -> list[tuple[str, float, list[float]]]:
    """What we hold ourselves to, its bound, and the values of ours; not what could not be measured."""
    full, light = ([r for r in rows if r["kitchen"].endswith(f", {weight}, bare")] for weight in ("full", "light"))
    values = {
        "make + write": [r["make_s"] + r["write_s"] for r in full],
        "check": [r["check_s"] for r in full],
        "load": [r["load_s"] for r in full + light],
        "load in 3.3.7": [r["load_old_s"] for r in full + light if r["load_old_s"] is not None],
        "full, at work": [r["stirred"]["real_time"] for r in full],
        "light, at work": [r["stirred"]["real_time"] for r in light],
        "full, awake": [r["awake"]["real_time"] for r in full],
        "light, awake": [r["awake"]["real_time"] for r in light],
    }
    return [(what, TARGETS[what], found) for what, found in values.items() if found]


def machine() -> str:
    """What it ran on, and how busy that was."""
    busy, python = os.getloadavg()[0], platform.python_version()
    return f"{platform.machine()}, {os.cpu_count()} cores, load {busy:.1f}, Python {python}"


if __name__ == "__main__":
    raise SystemExit(main())
