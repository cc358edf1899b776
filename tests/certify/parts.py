"""The parts of `./dev certify`: what each proves and by which commands."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
OUT = ROOT / "out" / "certify"
SHARED = Path(os.environ.get("CASA_SHARED", ROOT.parent / "shared"))
PROGRAM = str(Path(sys.executable).with_name("casa-assets"))
# The tests of every change, also those whose code has not changed.
EVERY_CHANGE = "not consumers and (not certify or content)"
# Percent of the lines of casa_assets/ that they run in their own processes.
LEAST_COVERAGE = 75
# The tests of a release that are in none of the parts that record keys.
OF_A_RELEASE = "certify and not content"
CONSUMERS = "tests/consumers"
# Tests of other programs that take longest: name -> what they prove, and their files and folders.
LONG = {
    "pages": ("every code block of README and docs", ("test_documents.py", "test_notebook.py")),
    "meshes": (
        "public meshes, hostile inputs, broken plans, random members of families",
        ("test_content.py", "test_hostile_set.py", "test_public_meshes.py"),
    ),
    "robocasa": ("all atomic tasks of RoboCasa, fixtures by its classes", ("test_robocasa_tasks.py", "robocasa")),
    "engines": ("ten kitchens in mujoco_warp, Newton and MJX, each held against MuJoCo", ("test_batches.py",)),
    "robots": ("all robots in whole kitchens", ("test_robots.py",)),
    "clusters": (
        "whole sets of meshes on one machine, in shards and on clusters that lose a machine",
        tuple(f"cluster/test_{name}.py" for name in ("faults", "whole_sets")),
    ),
    "soak": ("two hours on a cluster with faults at random", ("cluster/test_soak.py",)),
}


@dataclass(frozen=True)
class Part:
    """A proof.

    Attributes:
        name: short, for the command line. proves: a sentence. commands: run one after the other until one fails.
        after: run where all have passed, such as what records that they have. limit_s: no part of it may take longer.
    """

    name: str
    proves: str
    commands: tuple[tuple[str, ...], ...]
    after: tuple[tuple[str, ...], ...] = ()
    limit_s: int = 4 * 3600


def _pytest(marks: str, *words: str, by: str = "worksteal") -> tuple[str, ...]:
    durations = ("--durations", "25", "--durations-min", "10")
    return (sys.executable, "-m", "pytest", "-n", "auto", "--dist", by, "-q", *durations, "-m", marks, *words)


def _on_sid() -> tuple[tuple[str, ...], ...]:
    tool, folder = str(SHARED / "tools" / "fresh_root.sh"), str(OUT / "sid")
    script = (
        '[ ! -d "$2" ] || bash "$1" drop "$2" || exit 1; bash "$1" make sid "$2" && bash "$1" run "$2" "$3" "./dev run"'
    )
    script += '; code=$?; bash "$1" drop "$2" || code=1; exit $code'
    return (("bash", "-c", script, "run_on_sid", tool, folder, str(ROOT)),)


def parts() -> list[Part]:
    """All of them, those first that end soonest."""
    kitchens = str(OUT / "scenes")
    record = (sys.executable, "-m", "tests.content_keys", "--write")
    return [
        Part("sid", "`./dev run` on a bare Debian sid, with the newest Python", _on_sid()),
        Part("textures", "all textures, one by one and as sets", ((PROGRAM, "textures", "check"),)),
        Part(
            "tests",
            "all of `./dev test` with every preset, object, texture, plan and style; the share of lines that run",
            (_pytest(EVERY_CHANGE, "--cov", "--cov-report=term", f"--cov-fail-under={LEAST_COVERAGE}", "tests"),),
            (record,),
        ),
        Part(
            "package",
            "further rows and longer runs of the tests of the package",
            (_pytest(OF_A_RELEASE, "tests/unit", by="loadfile"),),
        ),
        Part(
            "hostile",
            "hostile files, kills, determinism, parity, properties",
            (_pytest(OF_A_RELEASE, *_kinds_of_tests(), by="loadfile"),),
        ),
        Part(
            "programs",
            "all other programs but those below",
            (_pytest(OF_A_RELEASE, *_other_consumers(), by="loadfile"),),
        ),
        *(
            Part(name, proves, (_pytest(OF_A_RELEASE, *(f"{CONSUMERS}/{path}" for path in paths), by="loadfile"),))
            for name, (proves, paths) in LONG.items()
        ),
        Part(
            "kitchens", "all kitchens, built and checked", ((PROGRAM, "scenes", "check", "--all", "--out", kitchens),)
        ),
        Part("batch forms", "the batch form of each", ((PROGRAM, "scenes", "batch", "--all", "--out", kitchens),)),
        Part(
            "fuzz",
            "half an hour of random damage to meshes",
            ((sys.executable, "-m", "benchmarks.fuzz_ingest", "--minutes", "30", "--out", str(OUT / "fuzz")),),
        ),
    ]


def _other_consumers() -> list[str]:
    """Files and folders of tests/consumers that are not among the long ones."""
    long = {path.partition("/")[0] for _, paths in LONG.values() for path in paths}
    places = (path for path in sorted((ROOT / CONSUMERS).iterdir()) if path.name not in long)
    found = (p.name for p in places if p.name.startswith("test_") or (p.is_dir() and any(p.glob("test_*.py"))))
    return [f"{CONSUMERS}/{name}" for name in found]


def _kinds_of_tests() -> list[str]:
    """Folders of tests/ that hold tests, without unit/ and consumers/."""
    folders = (path for path in sorted((ROOT / "tests").iterdir()) if path.is_dir())
    return [f"tests/{f.name}" for f in folders if f.name not in ("unit", "consumers") and any(f.glob("test_*.py"))]


def environment() -> Mapping[str, str]:
    """Of all parts: the shared data, and a cache of their own, so that kitchens are proved from nothing."""
    return {**os.environ, "CASA_SHARED": str(SHARED), "CASA_ASSETS_CACHE": str(OUT / "cache")}
