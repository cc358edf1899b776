"""Builds random members of every family, runs every check on them and prints seconds and megabytes per asset.

    ./dev bench families                        20 members of each family
    ./dev bench families --samples 3 --jobs 1   fewer, on one core

Seconds are wall time, one process per member: `build` is numbers to Asset with the pictures of its finishes painted
or taken from the cache, `write` is both formats, `draw` the thumbnail, `check` every check. The exit code is 1 where
any member fails a check.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path
from statistics import median

from casa_assets.cli.build_output import print_member, print_members
from casa_assets.cli.output import Output
from casa_assets.core.system import CACHE_VARIABLE as CACHE
from casa_assets.pipeline.families.run import FamilyResult, build_all, requests_for


def main() -> int:
    """Build, print, and say whether all passed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="families; all where none is named")
    parser.add_argument("--samples", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=0)
    options = parser.parse_args()
    output = Output()
    results: list[FamilyResult] = []
    with tempfile.TemporaryDirectory() as folder:
        os.environ[CACHE] = str(Path(folder) / "cache")  # textures are painted, too
        for done in build_all(
            requests_for(options.names, options.samples, options.seed, False), Path(folder), options.jobs, False
        ):
            results.append(done)
            if not done.passed:
                print_member(done, output)
    print_members(results, output)
    made = [r for r in results if r.report]
    output.line(f"build and write: median {median(r.build_s + r.write_s for r in made):.3f} s per asset and core")
    whole = median(r.build_s + r.write_s + r.draw_s + r.check_s for r in made)
    output.line(f"with thumbnail and all checks: median {whole:.3f} s")
    return 0 if all(r.passed for r in results) else 1


if __name__ == "__main__":
    raise SystemExit(main())
