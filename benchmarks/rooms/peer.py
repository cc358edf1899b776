"""Makes one kitchen with scene_synthesizer, as URDF twice: as it writes it, and with its objects still told apart.

    python peer.py TEMPLATE SEED FOLDER

Runs in the peer's own environment. Prints one JSON object. MuJoCo merges all that is fixed in a URDF into the world;
the second file, apart.urdf, asks it not to, so that a clash of two objects can be told from two parts of one.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

APART = '<mujoco><compiler fusestatic="false" strippath="true"/></mujoco>'


def main() -> None:
    """Make, export, and tell the seconds."""
    template, seed, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
    begin = time.perf_counter()
    from scene_synthesizer import procedural_scenes

    imported = time.perf_counter()
    scene = getattr(procedural_scenes, template)(seed=seed)
    generated = time.perf_counter()
    folder.mkdir(parents=True, exist_ok=True)
    scene.export(str(folder / "kitchen.urdf"))
    urdf = time.perf_counter()
    scene.export(str(folder / "kitchen.usd"))
    usd = time.perf_counter()
    text = (folder / "kitchen.urdf").read_text(encoding="utf-8")
    head, _, rest = text.partition("<link")
    (folder / "apart.urdf").write_text(f"{head}{APART}<link{rest}", encoding="utf-8")
    names = sorted(str(name).replace("/", "_") for name in scene.get_object_names())
    (folder / "objects.json").write_text(json.dumps(names), encoding="utf-8")
    seconds = {"import_s": imported - begin, "generate_s": generated - imported}
    print(json.dumps({**seconds, "urdf_s": urdf - generated, "usd_s": usd - urdf}))


if __name__ == "__main__":
    main()
