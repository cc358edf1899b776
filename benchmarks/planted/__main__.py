"""How many of 120 planted faults the tests catch, by which test and after how long.

    ./dev bench planted                      all faults: hours on two cores; goes on where it was stopped
    ./dev bench planted --only ID ...        some of them
    ./dev bench planted --checkout FOLDER    the same faults in another checkout, such as an older one with its tests
    ./dev bench planted --check              only look whether every fault applies and its module can be imported

The faults are mistakes that a programmer might make (faults.yaml): a flipped sign, a wrong unit, a limit that nothing
holds any more. They were chosen by reading the code, not the tests. Each is planted in a copy of the checkout; the
tests that reach its module by imports (tests/selection.py) run in the order of their distance, and after them those
that start the program, until one fails or the budget is spent. A test that also fails without the fault does not count.

Prints one line a fault, then how many were caught by the nearest tests (those with the fewest imports between them and
the fault) and by others, per package and per kind of mistake, and those that none caught. Results are appended to
--out, by commit of the checkout and fault: what is known there is not tried again.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from benchmarks.planted.faults import FAULTS, Fault, copy_clean, mistakes, name_of, read_faults
from benchmarks.planted.trial import APPLIES_NOT, Bench, Results, Verdict, line_of, summary
from tests.selection import Imports, reaching

ROOT = Path(__file__).parents[2]
# Looks whether the text of each fault stands in its file, so it fails for every planted fault and catches none.
LEFT_OUT = "tests/unit/benchmarks/test_planted.py"


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--checkout", type=Path, default=ROOT, help="Folder of the checkout whose tests are judged.")
    parser.add_argument("--only", nargs="+", default=[], metavar="ID", help="These faults and no others.")
    parser.add_argument("--budget", type=float, default=120.0, metavar="S", help="Seconds of tests for each fault.")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="Processes of pytest.")
    parser.add_argument(
        "--python", default=sys.executable, help="Python with what the checkout needs, such as an old one."
    )
    parser.add_argument("--cache", type=Path, help="Folder of built things (CASA_TESTS_CACHE) to begin with.")
    parser.add_argument("--out", type=Path, default=ROOT / "out/bench/planted/results.jsonl", help="File of results.")
    parser.add_argument("--faults", type=Path, default=FAULTS, help="Another list of faults.")
    parser.add_argument("--check", action="store_true", help="Look at the list of faults and run no tests.")
    args = parser.parse_args()
    faults = read_faults(args.faults, args.only)
    if args.check:
        wrong = mistakes(faults, args.checkout, importing=args.checkout.resolve() == ROOT)
        print("\n".join([*wrong, f"{len(faults)} faults in {len({f.file for f in faults})} files, {len(wrong)} wrong"]))
        raise SystemExit(1 if wrong else 0)
    results = Results(args.out, name_of(args.checkout))
    verdicts = results.verdicts(faults, args.budget)
    todo = [fault for fault in faults if fault.id not in verdicts]
    print(f"{results.checkout}: {len(faults)} faults, {len(faults) - len(todo)} of them known", flush=True)
    if todo:
        _try_all(args, todo, results, verdicts)
    print(f"\n{summary(faults, verdicts)}")


def _try_all(args: argparse.Namespace, todo: list[Fault], results: Results, verdicts: dict[str, Verdict]) -> None:
    """Try faults one after the other, and keep what became of each."""
    imports = Imports(args.checkout)
    with tempfile.TemporaryDirectory(prefix="planted_", ignore_cleanup_errors=True) as folder:
        work = Path(folder)
        clean = copy_clean(args.checkout, work / "clean", args.jobs)
        bench = Bench(clean, work, args.jobs, args.budget, args.cache, args.python, results.clean_fails())
        for fault in todo:
            if fault.applies(clean):
                tests = [test for test in reaching(imports, [fault.file]) if test.path != LEFT_OUT]
                verdict = bench.try_fault(fault, tests)
            else:
                verdict = Verdict(APPLIES_NOT, 0.0, 0)
            results.add(fault, verdict, args.budget)
            results.add_clean(bench.clean_fails)
            verdicts[fault.id] = verdict
            print(line_of(fault, verdict), flush=True)


if __name__ == "__main__":
    main()
