"""The table of `ingest_pose`: targets beside what was measured, and the rows that miss."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from pxr import Usd, UsdPhysics

from casa_assets.library.library import Library

NEAR = 0.25  # of the true longest side
KEPT = 0.05  # a metric file may change by so much
SURE = 0.5  # below, a guess is for a person to look at
GOOD = ("exact", "same shape", "any pose", "lies", "stands")


def parity(folder: Path) -> list[dict[str, Any]]:
    """Mass of every asset of a library as MuJoCo compiles its MJCF, and as its USD states it, kg."""
    found = []
    for place in Library(folder).accepted():
        model = mujoco.MjModel.from_xml_path(str(place / "model.xml"))
        stage = Usd.Stage.Open(str(place / "usd" / f"{place.name}.usda"))
        stated = [UsdPhysics.MassAPI(p).GetMassAttr().Get() for p in stage.Traverse() if p.HasAPI(UsdPhysics.MassAPI)]
        found.append(
            {"id": place.name, "mjcf": float(model.body_mass.sum()), "usd": float(sum(v or 0 for v in stated))}
        )
    return found


def report(rows: Sequence[Any], masses: Sequence[dict[str, Any]]) -> str:
    """Markdown."""
    done = [r for r in rows if not r.failed]
    lines = [f"{len(rows)} inputs, {len(rows) - len(done)} could not be worked on.", ""]
    lines += ["| what | target | measured | |", "|---|---|---|---|"]
    lines += [*_scale_lines(done), *_pose_lines(done), *_mass_lines(done, masses), "", *_misses(done)]
    return "\n".join(lines) + "\n"


def _line(what: str, target: float, good: int, of: int, extra: str = "") -> str:
    if not of:
        return f"| {what} | {target:.0%} | no such rows | |"
    share = good / of
    verdict = "pass" if share >= target else f"miss by {100 * (target - share):.1f} points"
    return f"| {what} | {target:.0%} | {good} of {of} ({share:.1%}){extra} | {verdict} |"


def _error(row: Any) -> float:
    return abs(row.longest_m / row.true_m - 1)


def _scale_lines(rows: Sequence[Any]) -> list[str]:
    known = [r for r in rows if r.true_m is not None]
    odd, metric = [r for r in known if not r.metric], [r for r in known if r.metric]
    blind = [r for r in rows if r.true_m is None and r.high_m < 1e9]
    far = [r for r in known if _error(r) > NEAR]
    flagged = sum(r.scale_sure < SURE for r in far)
    verdict = "pass" if flagged == len(far) else "miss"
    return [
        _line(
            "within 25 % of the truth, files that are not metric", 0.9, sum(_error(r) <= NEAR for r in odd), len(odd)
        ),
        _line("changed by no more than 5 %, metric files", 1.0, sum(_error(r) <= KEPT for r in metric), len(metric)),
        _line("within the plausible range, no true size known", 0.9, _inside(blind), len(blind)),
        f"| wrong by more than 25 %, and for review | all | {flagged} of {len(far)} | {verdict} |",
        f"| sizes for review | | {sum(r.scale_sure < SURE for r in rows)} of {len(rows)} | |",
    ]


def _inside(rows: Sequence[Any]) -> int:
    return sum(r.low_m * 0.999 <= r.longest_m <= r.high_m * 1.001 for r in rows)


def _pose_lines(rows: Sequence[Any]) -> list[str]:
    judged = [r for r in rows if r.grade]
    lines = [
        _line("upright", 0.95, sum(r.grade in GOOD for r in judged), len(judged), _kinds([r.grade for r in judged]))
    ]
    for name in dict.fromkeys(n for r in judged for n in r.copies):
        of = [r for r in judged if name in r.copies]
        kinds = _kinds([r.copies[name] for r in of])
        asked = sum(r.copies[name] not in GOOD and r.copies_sure[name] < SURE for r in of)
        lines.append(_line(f"copies {name}, righted", 0.95, sum(r.copies[name] in GOOD for r in of), len(of), kinds))
        lines.append(
            f"| of those not righted, for review | | {asked} of {sum(r.copies[name] not in GOOD for r in of)} | |"
        )
    wrong = [r for r in judged if r.grade not in GOOD]
    lines.append(
        f"| poses for review | | {sum(r.up_sure < SURE for r in rows)} of {len(rows)}, "
        f"{sum(r.up_sure < SURE for r in wrong)} of the {len(wrong)} wrong ones | |"
    )
    return lines


def _kinds(grades: Sequence[str]) -> str:
    counts = Counter(grades)
    return ": " + ", ".join(f"{counts[name]} {name}" for name in (*GOOD, "on its head", "wrong") if counts[name])


def _mass_lines(rows: Sequence[Any], masses: Sequence[dict[str, Any]]) -> list[str]:
    inside = sum(r.mass_span[0] * 0.999 <= r.mass_kg <= r.mass_span[1] * 1.001 for r in rows)
    lines = [_line("mass within the range of the category", 1.0, inside, len(rows))]
    for name, low, high in (("apple", 0.1, 0.3), ("mug", 0.25, 0.5)):
        of = [r.mass_kg for r in rows if r.category == name]
        message = f", {min(of):.3g} to {max(of):.3g} kg" if of else ""
        good = sum(low <= kg <= high for kg in of)
        lines.append(_line(f"{name}s of {low:g} to {high:g} kg", 1.0, good, len(of), message))
    lines.append(f"| masses for review | | {sum(r.mass_sure < SURE for r in rows)} of {len(rows)} | |")
    if masses:
        off = [abs(m["mjcf"] / m["usd"] - 1) if m["usd"] else np.inf for m in masses]
        good = sum(v <= 1e-6 for v in off)
        lines.append(_line("MJCF and USD weigh the same, to 1e-6", 1.0, good, len(off), f", worst {max(off):.1e}"))
    return lines


def _misses(rows: Sequence[Any]) -> list[str]:
    lines = ["| size missed | category | true (m) | ours (m) | sure | |", "|---|---|---|---|---|---|"]
    for r in rows:
        limit = None if r.true_m is None else KEPT if r.metric else NEAR
        if limit is not None and _error(r) > limit:
            lines.append(
                f"| {r.path} | {r.category} | {r.true_m:.3g} | {r.longest_m:.3g} | {r.scale_sure:.0%} | {r.scale} |"
            )
        elif limit is None and r.high_m < 1e9 and not _inside([r]):
            span = f"{r.low_m:g} to {r.high_m:g}"
            lines.append(f"| {r.path} | {r.category} | {span} | {r.longest_m:.3g} | {r.scale_sure:.0%} | {r.scale} |")
    lines += ["", "| pose missed | category | as it is | copies | sure |", "|---|---|---|---|---|"]
    for r in rows:
        copies = ", ".join(n for n, g in r.copies.items() if g not in GOOD)
        if (r.grade and r.grade not in GOOD) or copies:
            as_it_is = r.grade if r.grade not in GOOD else ""
            lines.append(f"| {r.path} | {r.category} | {as_it_is} | {copies} | {r.up_sure:.0%} |")
    return lines
