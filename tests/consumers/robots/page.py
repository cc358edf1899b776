"""The rows of docs/numbers.md about what robots reach in kitchens, from a folder of scenes that were certified.

`python -m tests.consumers.robots.page FOLDER` prints them.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

KITCHENS = ("l_small__coastal", "u_small__traditional_1")  # of all robots
# One of each other plan, of PandaOmron.
PLANS = (
    "g_large__modern_1",
    "g_small__farmhouse",
    "galley__industrial",
    "l_large__mediterranean",
    "one_wall_large__industrial",
    "one_wall_small__modern_2",
    "u_large__rustic",
    "wraparound__transitional_1",
)
ASKED = "PandaOmron"
COUNTS = ("joints", "reached", "followed", "without_parking")


def rows(folder: Path) -> list[str]:
    """Rows of a Markdown table, one a robot: kitchens, joints, reached, followed, without a parking place.

    Args:
        folder: of scenes; those of `KITCHENS` and `PLANS` have a robots.json of a whole run.
    """
    names = (*KITCHENS, *PLANS)
    found = [json.loads((folder / name / "robots.json").read_text(encoding="ascii"))["counts"] for name in names]
    lines = []
    for robot in sorted(found[0]):
        counts = [kitchen[robot] for kitchen in (found if robot == ASKED else found[: len(KITCHENS)])]
        sums = [sum(one[key] for one in counts) for key in COUNTS]
        lines.append(f"| {' | '.join(map(str, (robot, len(counts), *sums)))} |")
    return lines


if __name__ == "__main__":
    print("\n".join(rows(Path(sys.argv[1]))))
