"""Make the golden set and compare digests of all files with `digests.json`; `./dev golden` runs this.

The set: the twelve sample meshes, the two sample appliances, three kitchens with every check, twenty presets of
families and twenty generated objects, each as MJCF and USD. Exit 1 if files changed, are missing or are new.

    ./dev golden                  compare; about three minutes on two cores
    ./dev golden --write          record what is written now; CHANGELOG.md has to say what changed and why

Left out, because they are meant to differ from run to run or with any change of the code: caches, times, pages,
SQLite tables, and in certificates and summaries the keys and versions of the code. Digests are recorded for one Python,
one version of each library and one renderer; another machine may draw other pictures, and its user can leave these
out with --no-pictures.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import casa_assets as casa
from casa_assets.registry.families import object_names

ROOT = Path(__file__).parents[2]
DIGESTS = Path(__file__).parent / "digests.json"
KITCHENS = ("l_small__coastal", "one_wall_large__mediterranean", "g_small__rustic")
PRESETS = OBJECTS = 20
LEFT_OUT = re.compile(r"(^|/)\.casa/|\.(html|sqlite|js)$")
PICTURES = re.compile(r"\.(png|jpg)$")
# Of JSON files: keys and versions, which any change of the code changes, and what a clock measured.
LEFT_OUT_FIELDS = re.compile(r"(^|_)key$|^versions$|seconds$|^(cpu|clock|check)_s|^speed$|^load_ms|^real_time_factor")
MEASURED = ("SCN026", "SCN027")  # checks of speed


def make_appliances(folder: Path) -> None:
    """The sample appliances, articulated; parts of low confidence wait for a person."""
    for name in ("microwave.obj", "oven.glb"):
        _run("articulate", f"examples/appliances/{name}", "--library", folder, accepted=(0, 4))


def make_presets(folder: Path) -> None:
    """Twenty presets, of families that are evenly spread over the alphabet: of the i-th its i-th preset."""
    families = casa.families()
    for i, family in enumerate(_spread(families, PRESETS)):
        names = sorted(families[family].presets)
        casa.build(family, names[i % len(names)]).write(folder / family)


def make_objects(folder: Path) -> None:
    """Twenty objects, of categories that are evenly spread over the alphabet."""
    for name in _spread(object_names(), OBJECTS):
        casa.build(f"objects/{name}", seed=7).write(folder / name)


SETS: dict[str, Callable[[Path], None]] = {
    "kitchens": lambda folder: _run("scenes", "check", *KITCHENS, "--no-pictures", "--no-3d", "--out", folder),
    # One of the meshes is rejected on purpose.
    "assets": lambda folder: _run("ingest", "examples/meshes", "--library", folder, accepted=(0, 1)),
    "appliances": make_appliances,
    "presets": make_presets,
    "objects": make_objects,
}


def _spread(names: Iterable[str], count: int) -> list[str]:
    """So many of some names, evenly spread over their alphabet."""
    ordered = sorted(names)
    return [ordered[i * len(ordered) // count] for i in range(count)]


def digests(folder: Path) -> dict[str, str]:
    """First 16 hex digits of sha256 over names and bytes of the files of one kind in one folder: `mug/meshes/*.obj`."""
    found: dict[str, Any] = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if path.is_file() and not LEFT_OUT.search(name.as_posix()):
            data = path.read_bytes()
            if path.suffix == ".json":
                data = json.dumps(_without_versions(json.loads(data)), sort_keys=True).encode()
            total = found.setdefault((name.parent / f"*{path.suffix}").as_posix(), hashlib.sha256())
            total.update(path.name.encode() + b"\0" + hashlib.sha256(data).digest())
    return {name: total.hexdigest()[:16] for name, total in found.items()}


def _without_versions(value: Any) -> Any:
    """A JSON value without what LEFT_OUT_FIELDS names, and without the numbers of checks of speed."""
    if isinstance(value, dict):
        is_measured = value.get("code") in MEASURED
        return {
            k: _without_versions(v)
            for k, v in value.items()
            if not LEFT_OUT_FIELDS.search(k) and not (is_measured and k == "number")
        }
    return [_without_versions(v) for v in value] if isinstance(value, list) else value


def _run(*arguments: object, accepted: tuple[int, ...] = (0,)) -> None:
    command = [sys.executable, "-m", "casa_assets.cli.main", *map(str, arguments), "--quiet"]
    code = subprocess.run(command, cwd=ROOT, check=False).returncode
    if code not in accepted:
        raise SystemExit(f"{' '.join(map(str, arguments))} ended with exit code {code}")


def _compare(found: dict[str, str], recorded: dict[str, str]) -> int:
    """Print each difference; the number of them."""
    lines = [f"new      {name}" for name in found.keys() - recorded.keys()]
    lines += [f"missing  {name}" for name in recorded.keys() - found.keys()]
    lines += [f"changed  {name}" for name in found.keys() & recorded.keys() if found[name] != recorded[name]]
    print("\n".join(sorted(lines, key=lambda line: line.partition("  ")[2].strip())), end="\n" if lines else "")
    return len(lines)


def main() -> int:
    """Make, compare, tell; see the text of the module."""
    parser = argparse.ArgumentParser(prog="./dev golden", description=__doc__.partition("\n")[0])
    parser.add_argument("sets", nargs="*", metavar="SET", help=f"some of: {', '.join(SETS)}; default: all")
    parser.add_argument("--write", action="store_true", help="record the digests of what is written now")
    parser.add_argument("--no-pictures", action="store_true", help="do not compare pictures")
    parser.add_argument(
        "--compare", type=Path, metavar="DIR", help="compare what `--keep` left in this folder; make nothing"
    )
    parser.add_argument("--keep", type=Path, metavar="DIR", help="leave what was made in this folder, to look at it")
    options = parser.parse_args()
    if unknown := set(options.sets) - SETS.keys():
        parser.error(f"unknown set {', '.join(sorted(unknown))}; there are {', '.join(SETS)}")
    chosen = options.sets or list(SETS)
    folder = options.compare or options.keep or Path(tempfile.mkdtemp(prefix="golden_"))
    try:
        # What is built has to come from this code, not from a cache that another run has filled.
        os.environ["CASA_ASSETS_CACHE"] = str(folder / "cache")
        found: dict[str, str] = {}
        for name in chosen:
            if options.compare is None:
                SETS[name](folder / name)
            found |= {f"{name}/{path}": digest for path, digest in digests(folder / name).items()}
    finally:
        if options.keep is None and options.compare is None:
            shutil.rmtree(folder, ignore_errors=True)
    recorded: dict[str, str] = json.loads(DIGESTS.read_text(encoding="utf-8")) if DIGESTS.exists() else {}
    others = {path: digest for path, digest in recorded.items() if path.partition("/")[0] not in chosen}
    if options.write:
        DIGESTS.write_text(json.dumps(others | found, indent=0, sort_keys=True) + "\n", encoding="utf-8")
        print(f"recorded {len(found)} kinds of files")
        return 0
    expected = {path: digest for path, digest in recorded.items() if path not in others}
    if options.no_pictures:
        found, expected = (
            {path: digest for path, digest in one.items() if not PICTURES.search(path)} for one in (found, expected)
        )
    count = _compare(found, expected)
    print(f"{'FAIL' if count else 'ok'}  {len(found)} kinds of files, {count} differences")
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main())
