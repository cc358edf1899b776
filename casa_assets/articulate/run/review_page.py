"""Write review.html: a page on which a person looks at articulated meshes, the least certain first, and corrects them.

The page is written next to the pictures and models that it shows, loads nothing else, and writes a review.json (see
library/review.py).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from casa_assets import registry
from casa_assets.articulate.plan import HingeEdge, PartKind
from casa_assets.articulate.run.steps import NAME as STRIP
from casa_assets.articulate.run.steps import ArticulateOutcome, moving_joints
from casa_assets.cache.cache_key import digest_of
from casa_assets.library.entry_files import PICTURE
from casa_assets.library.library import Library
from casa_assets.library.mesh_decisions import mesh_decisions
from casa_assets.model.issue import Decision
from casa_assets.show.page.page_template import PageModels, models_of, relative_link, render_template, write_models
from casa_assets.show.stills.still import CELL_PX, part_color, strip_corners

NAME = "review.html"
TITLE = "Articulated meshes"
# Directions of a file that may be up or the front.
AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
_RANKS = {Decision.REJECTED: 0, Decision.REVIEW: 1, Decision.ACCEPTED: 2}


def write(out: Path, done: Sequence[ArticulateOutcome], command: str) -> Path:
    """Write the page into the folder of the library; return its path.

    Args:
        command: that applies the review.json that the page writes.
    """
    out.mkdir(parents=True, exist_ok=True)
    target = out / NAME
    for _ in write_models(out, target):
        pass
    page = render_page(Library(out), done, command, models=models_of(target))
    fresh = target.with_name(f".{NAME}.{os.getpid()}")
    fresh.write_text(page, encoding="utf-8")
    fresh.replace(target)
    return target


def render_page(
    library: Library,
    done: Sequence[ArticulateOutcome],
    command: str,
    is_served: bool = False,
    title: str = TITLE,
    models: PageModels | None = None,
) -> str:
    """Return the HTML of the page.

    Args:
        is_served: a server takes each decision at once; else the page writes a file. title: plain text.
        models: where the page finds the models of its assets; None: it shows pictures alone.
    """
    ranked = sorted(done, key=_rank)
    return render_template(
        "articulate/review.html",
        title=title,
        count=len(ranked),
        data={**_data(ranked, library, models), "served": is_served},
        command=command,
        without_scripts="decisions.yaml beside each model",
        scripts=("review/common.js", "model/model.js", "articulate/decisions.js", "articulate/review.js"),
    )


def _rank(done: ArticulateOutcome) -> tuple[int, float, str]:
    """Return the sorting key of a mesh: by outcome, then by the confidence of the least certain decision."""
    found = done.articulation
    least = 0.0 if found is None else min([found.frame.confidence, *(part.confidence for part in found.parts)])
    return _RANKS[done.decision], least, str(done.mesh)


def _data(done: Sequence[ArticulateOutcome], library: Library, models: PageModels | None) -> dict[str, Any]:
    """Return all that the page shows: `rows` of meshes, and the words that a person can choose from."""
    decided = mesh_decisions(library)
    rows = []
    for one in done:
        own = decided.get(one.sha256)
        stated = {} if own is None else own.model_dump(mode="json", exclude_defaults=True)
        rows.append({**_row(one, library.root, models), "decisions": stated})
    return {
        "rows": rows,
        "kinds": [kind.value for kind in PartKind],
        "edges": [edge.value for edge in HingeEdge],
        "axes": AXES,
        "categories": sorted(registry.load().fixtures),
        "cell_px": CELL_PX,
        # What is kept in the browser belongs to these rows alone.
        "digest": digest_of([(row["sha256"], row["decisions"]) for row in rows]),
    }


def _row(done: ArticulateOutcome, root: Path, models: PageModels | None) -> dict[str, Any]:
    folder = done.folder
    place = None if folder is None else Path(os.path.relpath(folder, root)).as_posix()
    row: dict[str, Any] = {
        "sha256": done.sha256,
        "name": str(done.mesh),
        "status": done.decision.value,
        "code": done.code,
        "message": done.reason_kept or done.message,
        "to_decide": done.to_decide,
        "link": None if place is None else f"{relative_link(place)}/",
        "summary": "",
        "parts": [],
        "corners": {},
    }
    for name, file in (("strip", STRIP), ("picture", PICTURE)):
        row[name] = relative_link(f"{place}/{file}") if folder is not None and (folder / file).exists() else ""
    row["strip_px"] = _png_size(folder / STRIP) if folder is not None and row["strip"] else (0, 0)
    has_model = models is not None and folder is not None and done.decision is not Decision.REJECTED
    row["model"] = vars(models.of(folder.name)) if has_model and models is not None and folder is not None else None
    if done.articulation is None:
        return row
    moving = moving_joints(done)
    corners = strip_corners(moving)
    frame = done.articulation.frame
    held = f"holds the contract {done.contract}" if done.contract else "; ".join(done.unmet_checks[:2])
    row["summary"] = "; ".join(w for w in (done.category, done.size, f"frame {frame.confidence:.0%} sure", held) if w)
    row["corners"] = corners
    row["parts"] = [{**_part(done, i), "corner": corners.get(m.joint)} for i, m in enumerate(moving)]
    return row


def _part(done: ArticulateOutcome, number: int) -> dict[str, Any]:
    assert done.articulation is not None
    part = done.articulation.parts[number]
    joint, travel = part.joint, done.travels[part.name]
    share = min(travel.free_share, travel.pushed_share)
    return {
        "name": part.name,
        "color": f"rgb({', '.join(str(round(255 * c)) for c in part_color(number))})",
        "joint_name": travel.joint,
        "kind": part.kind.value,
        "added": part.added,
        "on": part.parent or "body",
        "joint": joint.kind.value,
        "edge": joint.edge.value if joint.edge else "",
        "runner_up": joint.runner_up,
        "confidence": part.confidence,
        "reason": part.full_reason,
        "goes": "" if travel.is_full else f"{share:.0%} {travel.blocked_by}".strip(),
    }


def _png_size(path: Path) -> tuple[int, int]:
    with Image.open(path) as picture:
        return picture.size
