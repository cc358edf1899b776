"""Inputs of a run that is done in shards: what one shard alone would decide otherwise than a run over all of them."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

from casa_assets.ingest.run.run import Options, ingest
from casa_assets.ingest.run.shards import Shard
from tests.support.library.libraries import BOXES, CUT_GLB, box_obj, differences, write_files

# One box of cereal in three heights: each is a copy of its neighbour, and the first and the last are none.
CEREAL_HEIGHTS_M = (0.290, 0.297, 0.304)
SHEET = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def make_sharded_inputs(folder: Path) -> Path:
    """Same bytes twice, copies and a chain of them, rejects, a manifest with refused rows, an archive of meshes."""
    texts: dict[str, str] = {
        "milk_carton.obj": box_obj(BOXES["milk_carton"]),
        "copies/milk.obj": "# the same again\n" + box_obj(BOXES["milk_carton"]),
        "cutting_board.obj": box_obj(BOXES["cutting_board"]),
        "twins/plank.obj": box_obj(BOXES["cutting_board"]),
        "sheet.obj": SHEET,
        "unread.obj": "",
        "rows/box.obj": box_obj((0.1, 0.2, 0.05)),
    }
    for number, height in enumerate(CEREAL_HEIGHTS_M):
        texts[f"chain_{number}/cereal_box.obj"] = box_obj((0.19, height, 0.06))
    rows = [{"id": "a", "file": "gone.glb"}, {"id": "b", "file": "box.obj", "category": "bread"}, {"id": "b"}, 5]
    texts["rows/manifest.jsonl"] = "\n".join(map(json.dumps, rows)) + "\n"
    write_files(folder, texts)
    with zipfile.ZipFile(folder / "pack.zip", "w") as pack:
        pack.writestr("qwxz.obj", box_obj((0.11, 0.12, 0.13)))
        pack.writestr("inner/broken.glb", CUT_GLB)
        pack.writestr("inner/milk_carton.obj", box_obj(BOXES["milk_carton"]))
    return folder


def run_shards(source: Path, folder: Path, count: int, **options: Any) -> list[Path]:
    places = [folder / f"{index}_of_{count}" for index in range(1, count + 1)]
    for index, place in enumerate(places, 1):
        list(ingest([source], Options(place, jobs=1, shard=Shard(index, count), **options)))
    return places


def public_differences(one: Path, other: Path) -> list[str]:
    """Paths at which two libraries differ, but for their private folders."""
    return [path for path in differences(one, other) if path.split("/")[0] != ".casa"]
