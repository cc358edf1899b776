"""Prints docs/measured/robocasa_tasks.md: which atomic tasks of RoboCasa ran in which kitchens."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from casa_assets import __version__

HEAD = f"""# RoboCasa's atomic tasks in ten kitchens

Printed by `./dev consumers` of version {__version__}. The 65 atomic tasks of RoboCasa v1.0.1, unmodified, in one
kitchen of each floor plan:

- **x**: reset and moved to its goal by fixture states or moved objects; `_check_success` went from False to True
- o: `scene.json` affords it (`robocasa_v1`); `./dev certify` runs these too, with three seeds each
- (empty): the kitchen has not what the task wants

"""


def page(
    afforded: Mapping[str, Mapping[str, bool]], ran: Mapping[tuple[str, str], bool], kitchens: Sequence[str]
) -> str:
    """The page as Markdown.

    Args:
        afforded: kitchen -> task -> what its scene.json says. ran: (task, kitchen) -> whether it came to its goal.
        kitchens: ids, in the order of the columns.
    """
    lines = [HEAD, *(f"{number}. `{name}`\n" for number, name in enumerate(kitchens, 1))]
    lines += ["\n| task | " + " | ".join(str(k + 1) for k in range(len(kitchens))) + " |\n"]
    lines += ["|---" * (len(kitchens) + 1) + "|\n"]
    tasks = sorted(afforded[kitchens[0]])
    for task in tasks:
        cells = [_cell(afforded[name][task], ran.get((task, name))) for name in kitchens]
        lines.append(f"| {task} | " + " | ".join(cells) + " |\n")
    used = sum(any(afforded[name][task] for name in kitchens) for task in tasks)
    pairs = sum(afforded[name][task] for name in kitchens for task in tasks)
    done = sum(ran.values())
    lines.append(
        f"\n{used} of {len(tasks)} tasks are afforded by at least one of these kitchens, {pairs} pairs of task and "
        f"kitchen in all; {done} of {len(ran)} that ran came to their goal.\n"
    )
    return "".join(lines)


def _cell(is_afforded: bool, came: bool | None) -> str:
    if came is None:
        return "o" if is_afforded else " "
    return "**x**" if came else "failed"
