"""Write review.html: a page with pictures of all articulated meshes of a run, the least certain first."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from casa_assets.model.issue import Decision
from casa_assets.pipeline.articulate import sidecar
from casa_assets.pipeline.articulate.run import STRIP, ArticulateOutcome
from casa_assets.pipeline.reports.page_template import render_template

NAME = "review.html"
# Below this a decision is worth a look.
_LOW = 0.6


def write(out: Path, done: Sequence[ArticulateOutcome]) -> Path:
    """Write the page into the folder of the library; return its path."""
    ranked = sorted(done, key=lambda d: (d.accepted, _least(d), str(d.mesh)))
    page = render_template(
        "articulate_review.html",
        title="Articulated meshes",
        rows=[_row(d, out) for d in ranked],
        rejected=sum(d.decision is Decision.REJECTED for d in done),
        sidecar=sidecar.NAME,
        strip=STRIP,
    )
    out.mkdir(parents=True, exist_ok=True)
    target = out / NAME
    fresh = target.with_name(f".{NAME}.{os.getpid()}")
    fresh.write_text(page, encoding="utf-8")
    fresh.replace(target)
    return target


def _least(done: ArticulateOutcome) -> float:
    """Return the confidence of the least certain decision."""
    if done.articulation is None:
        return 0.0
    return min(
        [done.articulation.frame.confidence, *(min(p.confidence, p.joint.confidence) for p in done.articulation.parts)]
    )


def _row(done: ArticulateOutcome, out: Path) -> dict[str, Any]:
    """Return the section of one mesh."""
    row: dict[str, Any] = {"name": done.mesh.name, "folder": None, "code": done.code, "message": done.message}
    if done.articulation is None or done.folder is None:
        return row
    parts = []
    for part in done.articulation.parts:
        joint, way = part.joint, done.travels.get(part.name)
        confidence = min(part.confidence, joint.confidence)
        goes = (
            "" if way is None or way.is_full else f"goes {min(way.free_share, way.pushed_share):.0%} {way.blocked_by}"
        )
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        cells = (part.name, part.parent or "body", how, f"{confidence:.0%}", part.full_reason, joint.runner_up, goes)
        parts.append({"cells": cells, "is_doubtful": confidence < _LOW})
    frame = done.articulation.frame
    held = f"holds the contract {done.contract}" if done.contract else ": ".join(done.unmet_checks[:2])
    summary = "; ".join(w for w in (done.category, done.size, f"frame {frame.confidence:.0%} sure", held) if w)
    folder = Path(os.path.relpath(done.folder, out)).as_posix()
    return {**row, "folder": folder, "summary": summary, "parts": parts}
