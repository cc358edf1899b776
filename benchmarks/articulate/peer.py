"""Labelled cases of a generator by others, scene_synthesizer, drawn anew: a set that nothing was fitted on.

    python3 -m venv PEER && PEER/bin/pip install scene_synthesizer==1.15.0
    ./dev bench articulate_peer --python PEER/bin/python --out FOLDER [--seed 78] [--each 5]

Writes FOLDER/cases/<kind>_<k>/ with `input.obj`, `welded.obj`, `fused.obj` and gt.json, as `./dev bench
articulate_sets --sets FOLDER` and `./dev bench articulate --cases FOLDER` read them: cabinets divided at random,
microwaves, refrigerators, dishwashers, ranges, sink, base and wall cabinets. scene_synthesizer (Apache-2.0) needs an
environment of its own.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.articulate.cases.fuse import fused
from benchmarks.articulate.cases.labelled import LabelledMesh, write_case

SCRIPT = Path(__file__).parent / "cases" / "peer_assets.py"
# Share of the diagonal within which vertices are one in `welded.obj`, as in the articulation benchmark.
WELDED_SHARE = 1e-4
# Categories as the articulation benchmark names them.
CATEGORIES = {"range": "oven", "refrigerator": "fridge", "microwave": "microwave", "dishwasher": "dishwasher"}
# In this kind the front faces the other way.
FACING_BACK = "partitioned"


def main() -> None:
    """Draw and write the cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", type=Path, required=True, help="Interpreter that has scene_synthesizer.")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=78)
    parser.add_argument("--each", type=int, default=5)
    args = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        command = [str(args.python), str(SCRIPT), folder, "--seed", str(args.seed), "--each", str(args.each)]
        subprocess.run(command, check=True)
        for path in sorted(Path(folder).glob("*.json")):
            mesh = labelled(path)
            write_case(args.out / "cases" / path.stem, *fused(mesh), welded=WELDED_SHARE)
            kept = ("name", "category", "source")
            rows.append({k: mesh.truth[k] for k in kept} | {"tags": ["core", "proc"]})
    (args.out / "cases" / "index.json").write_text(json.dumps({"cases": rows}), encoding="utf-8")
    print(f"{len(rows)} written")


def labelled(path: Path) -> LabelledMesh:
    """A mesh with its truth, from what cases/peer_assets.py wrote."""
    told, arrays = json.loads(path.read_text(encoding="utf-8")), np.load(path.with_suffix(".npz"))
    part = arrays["part"].astype(np.int64)
    parts: list[dict[str, Any]] = []
    for row in told["parts"]:
        kind = next((k for word, k in (("basket", "tray"), ("drawer", "drawer")) if word in row["name"]), "door")
        joint = {key: row[key] for key in ("type", "axis", "origin", "range")}
        fixed = {"parent": "base", "scored": True, "visible": 0.5, "interior": kind == "tray"}
        parts.append({"id": row["id"], "name": row["name"], "type": kind, "joint": joint, **fixed})
    truth = {
        "name": path.stem,
        "category": CATEGORIES.get(told["kind"], "cabinet"),
        "up": "+Z",
        "front": "+Y" if told["kind"] == FACING_BACK else "-Y",
        "metric": True,
        "source": {"repo": told["kind"]},
        "parts": [p for p in parts if (part == p["id"]).any()],
    }
    return LabelledMesh(
        arrays["points"], arrays["faces"].astype(np.int64), part, np.zeros(len(part), dtype=bool), truth
    )


if __name__ == "__main__":
    main()
