"""What is wrong with meshes as they come, what our repair changes of it, and what trimesh's process and repair do.

    ./dev bench ingest_repair [folder of meshes ...] [--every 4] [--pictures 12]

Writes out/bench/ingest_repair.json and .md, and prints the latter. A folder with an index.json (a set of broken files)
contributes its rows of the class `geometry`. Both tools are handed the triangles as our readers leave them, and what
they make is measured by the same arithmetic, which no repair uses; trimesh gets all parts in one, and its normals,
textures and colours are not looked at; pictures are not even read. Seconds are those of the processor.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.ingest.judging.inputs import dump
from benchmarks.ingest.judging.repair import Soundness, Surface, soundness, trimesh_repaired
from benchmarks.ingest.judging.repair_report import Row, report
from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.draft import Draft, merge_parts
from casa_assets.ingest.run.survey import find_category
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found
from casa_assets.model.source import RawModel
from casa_assets.show.stills.still import render_model


def found_in(folder: Path) -> Iterator[Found]:
    """The inputs of a folder; of a set of broken files those whose geometry is broken."""
    index = folder / "index.json"
    paths = [folder]
    if index.is_file():
        rows = json.loads(index.read_text(encoding="utf-8"))
        paths = [folder / row["file"] for row in rows if row["cls"] == "geometry"]
    for path in paths:
        yield from (f for f in discover([path]) if isinstance(f, Found))


def judged(one: Found) -> tuple[Row, RawModel | None, Draft | None]:
    """Both tools on one input."""
    known = registry.load()
    category = known.category(find_category(one, "")[0].id)
    path, name = one.source.path, category.id
    limits = {**known.limits, "input_texture_pixels": 1.0}
    try:
        model = load(collect(one, limits), limits)
    except Rejected as error:
        return Row(path, name, refused=f"{error.code} {error.message}"), None, None
    start = time.process_time()
    try:
        draft = clean(model, category)
    except Rejected as error:
        return Row(path, name, refused=f"{error.code} {error.message}"), model, None
    seconds = time.process_time() - start
    raw = merge_parts(model.parts)
    surface = raw.vertices, raw.faces
    theirs, their_seconds, their_refusal = _theirs(surface)
    own = [n for n in draft.notes if n.code.startswith("MSH")]
    guess = next(g for g in draft.guesses if g.subject == "solidity")
    row = Row(
        path,
        name,
        before=soundness(surface),
        ours=soundness((draft.surface.vertices, draft.surface.faces)),
        theirs=theirs,
        seconds=round(seconds, 3),
        their_seconds=round(their_seconds, 3),
        same=_is_same(model, draft),
        notes=tuple(n.code for n in own),
        message=tuple(n.message for n in own),
        solidity=f"{guess.value}: {guess.reason}",
        their_refusal=their_refusal,
    )
    return row, model, draft


def _theirs(surface: Surface) -> tuple[Soundness | None, float, str]:
    try:
        repaired, seconds = trimesh_repaired(surface)
        return (
            (soundness(repaired) if len(repaired[1]) else None),
            seconds,
            "" if len(repaired[1]) else "nothing is left",
        )
    except Exception as error:  # noqa: BLE001 - whatever the peer fails with is its result
        return None, 0.0, f"{type(error).__name__}: {error}"[:120]


def _is_same(model: RawModel, draft: Draft) -> bool:
    return len(model.parts) == len(draft.parts) and all(
        a.mesh.vertices.tobytes() == b.mesh.vertices.tobytes() and a.mesh.faces.tobytes() == b.mesh.faces.tobytes()
        for a, b in zip(model.parts, draft.parts, strict=True)
    )


def pictures(out: Path, row: Row, model: RawModel, draft: Draft) -> None:
    """The input before and after, side by side in name."""
    stem = row.path.replace("/", "_").rsplit(".", 1)[0][-60:]
    out.mkdir(parents=True, exist_ok=True)
    (out / f"{stem}_before.png").write_bytes(render_model(model))
    after = model.replace(parts=draft.parts)
    (out / f"{stem}_after.png").write_bytes(render_model(after))


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="*", default=[Path("examples/meshes")], help="meshes")
    parser.add_argument("--every", type=int, default=1, help="only every n-th input")
    parser.add_argument("--only", default="", help="only inputs with this in their path")
    parser.add_argument("--pictures", type=int, default=0, help="draw so many that were changed, before and after")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results go")
    given = parser.parse_args()
    rows: list[Row] = []
    sets: Sequence[tuple[Path, list[Found]]] = [(f, list(found_in(f))) for f in given.folders]
    by_set: dict[str, list[Row]] = {}
    for folder, inputs in sets:
        for one in [f for f in inputs if given.only in f.source.path][:: given.every]:
            row, model, draft = judged(one)
            rows.append(row)
            by_set.setdefault(folder.name, []).append(row)
            print(f"{row.path}: {' '.join(row.notes) or row.refused or 'sound'} {row.seconds:.2f} s", flush=True)
            drawn = Counter(r.same for r in rows)[False]
            if model is not None and draft is not None and not row.same and drawn <= given.pictures:
                pictures(given.out / "ingest_repair", row, model, draft)
    dump(given.out / "ingest_repair.json", [asdict(r) for r in rows])
    text = report(by_set)
    (given.out / "ingest_repair.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
