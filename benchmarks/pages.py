"""Seconds, memory and bytes of the page about a library of 2,500 inputs, and seconds that it takes in a browser.

    ./dev bench pages [--count 2500] [--kitchens 2500] [--out out/bench]

Writes a library of synthetic entries: an asset.json each, with category, size, mass, guesses, advice and 60 results of
checks drawn by chance, a picture that all share; one in twenty is a rejection, one in twelve is in review. Then it
writes the page twice (the first time every entry is read, the second time the table of entries has them), and opens
it in a headless Chromium: seconds to the first row, and from a key or a click to the next drawn frame
for a search, an order, a filter, a jump to the middle of the list, and until the details of a row stand there. The
same of the page that finds one of 2,500 kitchens. Needs Chromium and the environment that `./dev consumers` makes for
it. Seconds are those on the clock; those of processors are told beside them where the page is written.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.checks.table.table import TABLE
from casa_assets.pipeline.reports import kitchens, library_page
from tests.browser import Browser
from tests.built_libraries import keep
from tests.unit.pipeline.test_alike import FIRST

ROOT = Path(__file__).resolve().parents[1]
REJECTED_SHARE, REVIEW_SHARE = 1 / 20, 1 / 12
CODES = ("SRC002", "MSH002", "FLT005", "FLT010", "RUN002")
FIXTURES = ("hob", "range", "fridge_french_door", "dishwasher", "microwave", "wall_oven", "kettle", "toaster", "sink")
# From an action to the frame in which its result is drawn; answers with milliseconds.
TIMED = """(async () => {{
  const begin = performance.now();
  {action};
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  return performance.now() - begin;
}})()"""
UNTIL = """(async () => {{
  const begin = performance.now();
  {action};
  while (!document.querySelector({wanted})) await new Promise((done) => setTimeout(done, 5));
  return performance.now() - begin;
}})()"""
SEARCH = (
    "const field = document.getElementById('search'); field.value = {words}; field.dispatchEvent(new Event('input'))"
)


def main() -> int:
    """Make the inputs, write and open the pages, print the numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2_500)
    parser.add_argument("--kitchens", type=int, default=2_500)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "bench")
    parser.add_argument("--write", type=Path, help="Only write the page of this library; a child of this benchmark.")
    asked = parser.parse_args()
    if asked.write:
        library_page.write(asked.write, asked.write / "report.html")
        return 0
    asked.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=asked.out) as place:
        library, rooms = Path(place) / "library", Path(place) / "scenes"
        make_library(library, asked.count)
        make_kitchens(rooms, asked.kitchens)
        print(f"cores: {len(os.sched_getaffinity(0))}, load: {os.getloadavg()[0]:.1f}")
        for name in ("written the first time", "written again"):
            print(f"{asked.count} inputs, {name}: {written(library)}")
        page = library / "report.html"
        print(f"page {page.stat().st_size / 1e6:.2f} MB")
        begin, cpu = time.perf_counter(), time.process_time()
        found, _ = kitchens.write(rooms)
        print(
            f"{asked.kitchens} kitchens, {time.perf_counter() - begin:.1f} s, {time.process_time() - cpu:.1f} s of it"
        )
        browser = Browser()
        try:
            for title, path, order in (("inputs", page, '[data-key="mass"]'), ("kitchens", found, "")):
                print(f"in the browser, {title}:")
                for what, seconds in in_browser(browser, path, order).items():
                    print(f"  {what:24} {seconds:6.2f} s")
        finally:
            browser.close()
    return 0


def written(library: Path) -> str:
    """Write the page in a process of its own; what it took."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, "-m", "benchmarks.pages", "--write", str(library)], check=True, cwd=ROOT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    # The most that any child took so far, which is this one or an earlier one of the same kind.
    return f"{time.perf_counter() - begin:.1f} s, {cpu:.1f} s of processors, {after.ru_maxrss / 1e3:.0f} MB"


def in_browser(browser: Browser, path: Path, order: str) -> dict[str, float]:
    """Seconds that a page takes for what people do with it."""
    begin = time.perf_counter()
    page = browser.open(path)
    page.wait("#list .id")
    found = {"first row": time.perf_counter() - begin}

    def timed(name: str, script: str) -> None:
        found[name] = page.evaluate(script) / 1000

    timed("search for two words", TIMED.format(action=SEARCH.format(words=json.dumps("o 1"))))
    timed("search taken away", TIMED.format(action=SEARCH.format(words='""')))
    if order:
        timed("another order", TIMED.format(action=f"document.querySelector('#heads {order}').click()"))
    timed("a filter", TIMED.format(action="document.querySelector('#facets button').click()"))
    timed("filter taken away", TIMED.format(action="document.querySelector('#chips button').click()"))
    timed("jump to the middle", TIMED.format(action="window.scrollTo(0, document.body.scrollHeight / 2)"))
    click = "document.querySelector('#list .id').click()"
    timed("details of a row", UNTIL.format(action=click, wanted='"#detail-body .facts"'))
    assert page.errors == [] or all("ERR_FILE_NOT_FOUND" in error for error in page.errors), page.errors
    return found


def make_library(root: Path, count: int) -> None:
    """A library of synthetic entries; all share the picture of one."""
    keep(root, [FIRST])
    first = root / "mug" / FIRST.id
    template = json.loads((first / "asset.json").read_text(encoding="utf-8"))
    records, draw = registry.load(), random.Random(1)
    names = sorted(records.categories)
    for i in range(count - 1):
        digest, name = hashlib.sha256(str(i).encode()).hexdigest(), draw.choice(names)
        if draw.random() < REJECTED_SHARE:
            _reject(root, digest, name, draw)
            continue
        folder = root / name / f"{name}_{digest[:10]}"
        folder.mkdir(parents=True)
        os.link(first / "preview.png", folder / "preview.png")
        text = json.dumps(_entry(template, folder.name, digest, records.categories[name], draw), sort_keys=True)
        (folder / "asset.json").write_text(text, encoding="utf-8")


def _entry(template: dict[str, Any], name: str, digest: str, category: Any, draw: random.Random) -> dict[str, Any]:
    """Content of an asset.json."""
    longest = category.longest_m.typical * draw.lognormvariate(0, 0.25)
    asset = {key: template["asset"][key] for key in ("provenance", "labels")}
    asset["provenance"] = {**asset["provenance"], "sha256": digest, "path": f"lot_{digest[:2]}/{name}.glb"}
    asset["provenance"]["guesses"] = [
        {"subject": subject, "value": "y", "confidence": round(draw.random(), 2), "reason": "drawn by chance"}
        for subject in ("up_axis", "scale", "mass")
    ]
    issues = []
    if draw.random() < REVIEW_SHARE:
        issues.append(
            {"code": "REV001", "severity": "warning", "pointer": "scale", "message": "is told on thin evidence"}
        )
    if draw.random() < 0.5:
        issues.append({"code": "SRC042", "severity": "warning", "pointer": "", "message": "states no licence"})
    results = [
        {"code": row.code, "status": "passed", "number": round(draw.random(), 4), "limit": 1.0, "unit": row.unit}
        for row in TABLE[:60]
    ]
    summary = {
        "extents": [longest * share for share in category.shape],
        "mass": category.mass_kg.typical * draw.lognormvariate(0, 0.4),
        "colliders": draw.randint(1, 32),
        "hull_vertices": 64,
        "faces": draw.randint(100, 20_000),
    }
    certificate = {key: value for key, value in template["certificate"].items() if key != "signature"}
    certificate |= {"summary": summary, "asset_digest": digest, "files": {}}
    certificate["report"] = {"subject": name, "results": results, "issues": issues}
    asset |= {"id": name, "labels": {**asset["labels"], "category": category.id}}
    return {"asset": asset, "certificate": certificate}


def _reject(root: Path, digest: str, category: str, draw: random.Random) -> None:
    folder = root / "rejected" / f"{category}_{digest[:10]}"
    folder.mkdir(parents=True)
    refusal = {
        "schema_version": 2,
        "producer": "ingest",
        "id": folder.name,
        "code": draw.choice(CODES),
        "message": "is broken; mend it",
        "category": category,
        "cache_key": "0" * 64,
        "sha256": digest,
        "source": {"kind": "folder", "path": f"lot_{digest[:2]}/{category}.glb"},
    }
    (folder / "reject.json").write_text(json.dumps(refusal), encoding="utf-8")


def make_kitchens(out: Path, count: int) -> None:
    """Folders of kitchens with what the page reads of them, without pictures."""
    draw = random.Random(2)
    for i in range(count):
        plan, style = f"plan_{i % 10}", f"style_{i % 12}"
        folder = out / f"{plan}__{style}__{i}"
        folder.mkdir(parents=True)
        fixtures = [
            {"layer": "things", "family": family, "joints": {"door": {}}} for family in draw.sample(FIXTURES, 6)
        ]
        facts = {
            "id": folder.name,
            "plan": plan,
            "style": style,
            "fixtures": fixtures,
            "tasks": {f"task_{j}": {"afforded": draw.random() < 0.6} for j in range(60)},
            "robocasa_v1": {},
            "surfaces": {"floor": f"floor_{draw.randint(0, 99)}", "wall": f"wall_{draw.randint(0, 99)}"},
            "room": {"bounds": [[0, -draw.uniform(2, 6), 0], [4, 0, 2.5]]},
        }
        (folder / "scene.json").write_text(json.dumps(facts), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
