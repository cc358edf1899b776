"""Prints docs/robots_table.md: how many joints of kitchens robots reach and follow, and what they do not reach."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

HEAD = """# What robots reach in whole kitchens

Printed by `./dev certify`, which runs `casa-assets scenes robots` (see [robots](robots.md)): joints that have a handle,
knob, key or lever and a parking place, how many of them a robot gets its hand to, how many it follows to their end, the
median of its margins, and how many joints more have no parking place and were not tried.

"""
COLUMNS = "| kitchen | robot | joints | reached | followed | margin | no place |\n" + "|---" * 7 + "|\n"
MISSED = """
What is not reached, in all of them together. *Out of reach*: no posture was found even where the robot may pass through
all else. *In the way*: one was found then. *Too thick*: it does not go between the fingers.
"""
KINDS = ("door", "drawer", "knob", "button", "rack", "lever", "spout", "handle")


def page(certificates: Sequence[Mapping[str, Any]], scenes: Sequence[Mapping[str, Any]]) -> str:
    """The page as Markdown.

    Args:
        certificates: contents of robots.json. scenes: of scene.json, in the same order.
    """
    lines = [HEAD, COLUMNS]
    for found in certificates:
        for robot, counts in sorted(found["counts"].items()):
            numbers = (
                counts["joints"],
                counts["reached"],
                counts["followed"],
                f"{100 * (counts['margin'] or 0.0):.0f} %",
            )
            cells = (found["scene"], robot, *map(str, numbers), str(counts["without_parking"]))
            lines.append(f"| {' | '.join(cells)} |\n")
    lines.append(MISSED)
    for robot in sorted({name for found in certificates for name in found["counts"]}):
        lines.append(f"\n**{robot}**: {_missed(robot, certificates, scenes)}.\n")
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
