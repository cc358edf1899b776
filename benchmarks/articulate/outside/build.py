"""Build the cases of all sources that are there, half of the origins apart."""

from __future__ import annotations

import json
import multiprocessing
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

from benchmarks.articulate.outside import sources
from benchmarks.articulate.outside.cases import build_case, read_truth
from benchmarks.articulate.outside.model import Unreadable, at_closed_pose, subtree
from benchmarks.articulate.outside.read import mjcf, sdf, urdf, usd

HALVES = ("looking", "sealed")
READERS = {".urdf": urdf.read, ".sdf": sdf.read, ".xml": mjcf.read, ".usd": usd.read, ".usda": usd.read}
READERS |= {".usdc": usd.read, ".world": sdf.read}
# Changes whenever cases come out otherwise.
VERSION = 2


def build(folder: Path, mirror: Path | None, jobs: int) -> None:
    """Build the cases that are missing, and print how many there are and why some are not."""
    places, missing = {}, {}
    every = sources.objects()
    for repo, commit in sorted({(o.repo, o.commit) for o in every}):
        try:
            places[repo, commit] = sources.checkout(repo, commit, folder / "repositories", mirror)
        except (FileNotFoundError, subprocess.CalledProcessError) as error:
            missing[repo, commit] = str(error)
    work = [(o, folder, places[o.repo, o.commit]) for o in every if (o.repo, o.commit) in places]
    reasons = {o.name: missing[o.repo, o.commit] for o in every if (o.repo, o.commit) in missing}
    with multiprocessing.get_context("spawn").Pool(jobs, maxtasksperchild=20) as pool:
        reasons |= {name: reason for name, reason in pool.imap_unordered(build_one, work) if reason}
    kept = {o.name: o for o in every if o.name not in reasons}
    for half in HALVES:
        mine = {name: o for name, o in kept.items() if o.is_sealed == (half == "sealed")}
        truths = {name: read_truth(folder / half / "cases" / name) for name in mine}
        index = [
            {"name": n, "category": t["category"], "source": {"repo": mine[n].origin}, "tags": []}
            for n, t in truths.items()
        ]
        place = folder / half / "cases"
        place.mkdir(parents=True, exist_ok=True)
        (place / "index.json").write_text(json.dumps({"cases": index}), encoding="utf-8")
        parts = sum(p["scored"] for t in truths.values() for p in t["parts"])
        origins, kinds = {o.origin for o in mine.values()}, {o.kind for o in mine.values()}
        print(f"{half}: {len(mine)} objects of {len(origins)} origins and {len(kinds)} kinds, {parts} moving parts")
    (folder / "left_out.json").write_text(json.dumps(reasons, indent=1, sort_keys=True), encoding="utf-8")
    if reasons:
        print(f"{len(reasons)} objects could not be built: {folder}/left_out.json tells why")


def build_one(job: tuple[sources.ObjectSource, Path, Path]) -> tuple[str, str]:
    """Build one case unless it is there; return its name and why it could not be built, or nothing."""
    one, folder, repository = job
    place = folder / ("sealed" if one.is_sealed else "looking") / "cases" / one.name
    stamp = json.dumps(
        [VERSION, one.commit, one.file, one.root, dict(one.types), dict(one.pose), one.still, one.without]
    )
    done = place / "stamp.json"
    if done.is_file() and done.read_text() == stamp:
        return one.name, ""
    shutil.rmtree(place, ignore_errors=True)
    try:
        path = repository / one.file
        if not path.is_file():
            raise Unreadable(f"'{one.file}' is missing")
        reader = READERS[path.suffix.lower()]
        more = {"link": one.root, "complete": not one.incomplete} if reader is mjcf.read else {}
        model = reader(path, repository, one.pose, **more)
        model = subtree(model, one.root) if one.root else model
        links = {n: link for n, link in model.links.items() if not (one.without and re.search(one.without, n))}
        model = at_closed_pose(replace(model, links=links), one.pose)
        source = {"repo": one.repo, "commit": one.commit, "path": one.file, "root": one.root}
        about = {"category": one.kind, "origin": one.origin, "licence": one.licence, "source": source}
        build_case(place, model, about, one.types, one.still)
    except Exception as error:  # noqa: BLE001  whatever is wrong with one object of others, the rest are built
        shutil.rmtree(place, ignore_errors=True)
        return one.name, f"{type(error).__name__}: {error}"
    done.write_text(stamp)
    return one.name, ""
