"""Prints docs/measured/robots.md: how many joints of kitchens robots reach and follow, and what they do not reach.

`python -m tests.consumers.robots.page FOLDER` prints it from a folder of scenes in which all of them were certified.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from casa_assets import __version__

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
HEAD = f"""# What robots reach in whole kitchens

Printed by `./dev certify` of version {__version__}, which runs `casa-assets scenes robots` (see
[robots](../howto/use/robots.md)): joints that have a handle, knob, key or lever and a parking place, how many of them a
robot gets its hand to, how many it follows to their end, the median of its margins, and how many joints more have no
parking place and were not tried.

"""
MORE = f"""
{ASKED} in one kitchen of each of the other plans; the rest of the 120 was not measured.

"""
COLUMNS = "| kitchen | robot | joints | reached | followed | margin | no place |\n" + "|---" * 7 + "|\n"
MISSED = """
What is not reached, in all of them together. *Out of reach*: no posture was found even where the robot may pass through
all else. *In the way*: one was found then. *Too thick*: it does not go between the fingers.
"""
KINDS = ("door", "drawer", "knob", "button", "rack", "lever", "spout", "handle")


def page(folder: Path) -> str:
    """The page as Markdown.

    Args:
        folder: of scenes; those of `KITCHENS` and `PLANS` have robots.json and scene.json of whole runs.
    """
    certificates, scenes = (
        [json.loads((folder / name / file).read_text(encoding="ascii")) for name in (*KITCHENS, *PLANS)]
        for file in ("robots.json", "scene.json")
    )
    count = len(KITCHENS)
    lines = [HEAD, _table(certificates[:count]), MORE, _table(certificates[count:], ASKED), MISSED]
    for robot in sorted(certificates[0]["counts"]):
        tried = len(certificates) if robot == ASKED else count
        missed = _missed(robot, certificates[:tried], scenes[:tried])
        lines.append(f"\n**{robot}** ({tried} kitchens): {missed}.\n")
    return "".join(lines)


def _table(certificates: Sequence[Mapping[str, Any]], only: str = "") -> str:
    """A line for each kitchen and robot, or for one robot alone."""
    lines = [COLUMNS]
    for found in certificates:
        for robot, counts in sorted(found["counts"].items()):
            if only not in ("", robot):
                continue
            numbers = (
                counts["joints"],
                counts["reached"],
                counts["followed"],
                f"{100 * (counts['margin'] or 0.0):.0f} %",
            )
            cells = (found["scene"], robot, *map(str, numbers), str(counts["without_parking"]))
            lines.append(f"| {' | '.join(cells)} |\n")
    return "".join(lines)


def _missed(robot: str, certificates: Sequence[Mapping[str, Any]], scenes: Sequence[Mapping[str, Any]]) -> str:
    """Kinds of joints that a robot does not reach, the most frequent first, each with its number and the reason."""
    kinds: Counter[tuple[str, str]] = Counter()
    for found, scene in zip(certificates, scenes, strict=True):
        categories = {fixture["name"]: fixture["category"].replace("_", " ") for fixture in scene["fixtures"]}
        for joint in next(row for row in found["robots"] if row["robot"] == robot)["joints"]:
            if not joint["reached"]:
                kinds[f"{categories[joint['fixture']]}, {_kind(joint)}", joint["missed"]] += 1
    ordered = sorted(kinds.items(), key=lambda row: (-row[1], row[0]))
    return "; ".join(f"{number} x {kind} ({why})" for (kind, why), number in ordered) or "nothing"


def _kind(joint: Mapping[str, Any]) -> str:
    """What a joint moves, by its own name."""
    name = joint["joint"].rpartition("__")[2]
    return next((kind for kind in KINDS if kind in name), name)


if __name__ == "__main__":
    sys.stdout.write(page(Path(sys.argv[1])))
