"""Draw labelled cases: what moves in truth, seen from a corner and from the front, beside what the tool finds.

    CASA_SHARED=/path/to/shared ./dev bench articulate_look CASE [CASE ...] --out PICTURE.png [--variant fused]

CASE is the folder of a case, as ./dev bench articulate_draw and ./dev bench articulate_track write it. Each part has a
colour, and what does not move is grey; the front is the one that the tool guesses.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from PIL import Image, ImageDraw

from benchmarks.articulate.cases.labelled import LabelledMesh, read_case
from benchmarks.articulate.scoring.score import frame_is_right, one
from casa_assets.articulate.plan import Articulation
from casa_assets.articulate.segment.orthographic import render_depth
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.surface import face_normals
from casa_assets.show.stills.still import part_color

# Size of a view and of the words above it, pixels.
VIEW_PX, GAP_PX, HEAD_PX = 230, 10, 18
# Rows: right, up and into the picture, in the frame.
FRONT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
GREY = (200, 200, 200)


def corner_axes(yaw: float = 35.0, pitch: float = 25.0) -> Floats:
    """Axes of a view from the right, above the front, in degrees."""
    a, b = np.radians(yaw), np.radians(pitch)
    right = np.array([np.cos(a), np.sin(a), 0.0])
    into = np.array([-np.sin(a) * np.cos(b), np.cos(a) * np.cos(b), -np.sin(b)])
    return np.array([right, np.cross(right, into), into])


def colours(count: int) -> Ints:
    """(count + 1, 3) colours: grey, and one for each part."""
    hues = [part_color(k) for k in range(count)]
    return np.array([GREY, *[[round(255 * c) for c in hue] for hue in hues]])


def view(points: Floats, faces: Ints, part: Ints, axes: Floats) -> Image.Image:
    """A view of a mesh in its frame, by the number of the part of each face."""
    seen = render_depth(points, faces, axes, VIEW_PX).face
    light = 0.45 + 0.55 * np.abs(face_normals(points, faces)[0] @ (np.array([0.35, 0.5, 0.8]) @ axes))
    shaded = np.clip(colours(int(part.max(initial=0)))[part] * light[:, None], 0, 255).astype(np.uint8)
    return Image.fromarray(np.where((seen >= 0)[..., None], shaded[seen], 255).astype(np.uint8))


def row(mesh: LabelledMesh, found: Articulation) -> Image.Image:
    """The three views of a case."""
    case = SimpleNamespace(V=mesh.points, F=mesh.faces, J=mesh.truth)
    points = (mesh.points - np.array(found.frame.origin)) @ found.frame.rotation.T * found.frame.scale
    ids = [part["id"] for part in mesh.parts]
    truth = np.array([ids.index(k) + 1 if k in ids else 0 for k in mesh.part.tolist()])
    told = np.zeros(len(mesh.faces), dtype=np.int64)
    for k, part in enumerate(found.parts):
        told[part.faces] = k + 1
    views = [view(points, mesh.faces, *v) for v in ((truth, corner_axes()), (truth, FRONT), (told, FRONT))]
    out = Image.new("RGB", (3 * (VIEW_PX + GAP_PX), max(v.height for v in views) + HEAD_PX), "white")
    for k, v in enumerate(views):
        out.paste(v, (k * (VIEW_PX + GAP_PX), HEAD_PX))
    wrong = "" if frame_is_right(found.frame, case) else ", wrong up or front"
    words = ", ".join(f"{part.name} {part.confidence:.2f}" for part in found.parts) or "nothing"
    ImageDraw.Draw(out).text((2, 2), f"{mesh.truth['name']}{wrong}. Found: {words}"[:118], fill="black")
    return out


def main() -> None:
    """Draw the cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=Path, nargs="+", metavar="CASE")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--variant", default="input")
    parser.add_argument("--columns", type=int, default=2)
    args = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    rows = []
    for folder in args.cases:
        mesh = read_case(folder, args.variant)
        rows.append(row(mesh, one(SimpleNamespace(V=mesh.points, F=mesh.faces, J=mesh.truth), False)[0]))
    columns = [rows[k :: args.columns] for k in range(args.columns)]
    size = max(sum(r.height for r in column) for column in columns)
    picture = Image.new("RGB", (args.columns * rows[0].width, size), "white")
    for k, column in enumerate(columns):
        top = 0
        for each in column:
            picture.paste(each, (k * each.width, top))
            top += each.height
    args.out.parent.mkdir(parents=True, exist_ok=True)
    picture.save(args.out, optimize=True)


if __name__ == "__main__":
    main()
