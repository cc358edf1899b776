"""A page of pictures to look through a batch of articulated meshes: the doubtful ones first."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path
from urllib.parse import quote

from casa_assets.pipeline.articulate import sidecar
from casa_assets.pipeline.articulate.run import STRIP, ArticulateOutcome

NAME = "review.html"
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 14px/1.45 system-ui, sans-serif; margin: 24px; color: #202225; background: #fff }}
article {{ border-top: 1px solid #d9dbde; padding: 14px 0 }} h2 {{ font-size: 16px; margin: 0 0 4px }}
img {{ max-width: 100%; height: auto }} table {{ border-collapse: collapse; margin: 6px 0 }}
td, th {{ text-align: left; padding: 1px 14px 1px 0; vertical-align: top; font-weight: 400 }}
th {{ color: #70757c }} .low {{ color: #b3261e }} .code {{ color: #b3261e; font-weight: 600 }}
</style></head><body><h1>{title}</h1>
<p>{count} meshes, {bad} rejected; the least certain first. To mend one, change its {sidecar} and run
<code>casa-assets articulate MESH --decisions FILE</code>.</p>
{rows}
</body></html>
"""
# Below this a decision is worth a look.
_LOW = 0.6


def write(out: Path, done: Sequence[ArticulateOutcome]) -> Path:
    """Write the page into the folder of the library; returns its path."""
    ranked = sorted(done, key=lambda d: (d.accepted, _least(d), str(d.mesh)))
    rows = "\n".join(_row(d, out) for d in ranked)
    bad = sum(not d.accepted for d in done)
    page = _PAGE.format(title="Articulated meshes", count=len(done), bad=bad, sidecar=sidecar.NAME, rows=rows)
    out.mkdir(parents=True, exist_ok=True)
    target = out / NAME
    fresh = target.with_name(f".{NAME}.{os.getpid()}")
    fresh.write_text(page, encoding="utf-8")
    fresh.replace(target)
    return target


def _least(done: ArticulateOutcome) -> float:
    """How sure the least certain decision is."""
    if done.found is None:
        return 0.0
    return min([done.found.frame.confidence, *(min(p.confidence, p.joint.confidence) for p in done.found.parts)])


def _row(done: ArticulateOutcome, out: Path) -> str:
    name = escape(done.mesh.name)
    if done.found is None or done.folder is None:
        return f'<article><h2>{name}</h2><span class="code">{escape(done.code)}</span> {escape(done.message)}</article>'
    where = quote(Path(os.path.relpath(done.folder, out)).as_posix())
    code = f' <span class="code">{escape(done.code)}</span> {escape(done.message)}' if done.code else ""
    cells = []
    for part in done.found.parts:
        joint, way = part.joint, done.travels.get(part.name)
        confidence = min(part.confidence, joint.confidence)
        goes = "" if way is None or way.whole else f"goes {min(way.free, way.reached):.0%} {way.against}"
        reason = "; ".join(w for w in (part.reason, joint.reason) if w)
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        low = ' class="low"' if confidence < _LOW else ""
        words = (part.name, part.parent or "body", how, f"{confidence:.0%}", reason, joint.runner_up, goes)
        cells.append(f"<tr{low}>" + "".join(f"<td>{escape(w)}</td>" for w in words) + "</tr>")
    head = "".join(f"<th>{w}</th>" for w in ("part", "on", "joint", "confidence", "reason", "else", ""))
    frame = done.found.frame
    held = f"holds the contract {done.contract}" if done.contract else ": ".join(done.unmet_checks[:2])
    message = "; ".join(w for w in (done.category, done.size, f"frame {frame.confidence:.0%} sure", held) if w)
    return (
        f'<article><h2><a href="{where}/">{name}</a>{code}</h2><div>{escape(message)}; '
        f'<a href="{where}/{sidecar.NAME}">decisions</a></div>'
        f'<img src="{where}/{STRIP}" loading="lazy" alt="{name}: closed, in colours, apart, open">'
        f"<table><tr>{head}</tr>{''.join(cells)}</table></article>"
    )
