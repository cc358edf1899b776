"""The sentence of docs/numbers.md about the atomic tasks of RoboCasa that ran."""

from __future__ import annotations

from collections.abc import Mapping, Sequence


def sentence(
    afforded: Mapping[str, Mapping[str, bool]], ran: Mapping[tuple[str, str], bool], kitchens: Sequence[str]
) -> str:
    """How many tasks and pairs are afforded, and how many of those that ran came to their goal.

    Args:
        afforded: kitchen -> task -> what its scene.json says. ran: (task, kitchen) -> whether it came to its goal.
        kitchens: ids.
    """
    tasks = sorted(afforded[kitchens[0]])
    used = sum(any(afforded[name][task] for name in kitchens) for task in tasks)
    pairs = sum(afforded[name][task] for name in kitchens for task in tasks)
    return (
        f"{used} of {len(tasks)} tasks are afforded by at least one of these kitchens, {pairs} pairs of task and "
        f"kitchen in all; {sum(ran.values())} of {len(ran)} that ran came to their goal."
    )
