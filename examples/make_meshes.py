"""Writes examples/meshes: samples of what arrives in practice, and a manifest that states their licence.

All but one have something wrong.

    python examples/make_meshes.py [folder]

The same bytes every time, on every machine.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from samples import SAMPLES

MESHES = (".glb", ".gltf", ".obj", ".ply", ".stl", ".dae")


def main(folder: Path) -> None:
    """Write every sample into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for sample in SAMPLES:
        files = sample()
        for name, data in files.items():
            (folder / name).write_bytes(data)
            print(f"{len(data):8d}  {name}")
        main_file = next(name for name in files if Path(name).suffix in MESHES)
        title = Path(main_file).stem
        rows.append(
            {"id": title, "file": main_file, "name": title.replace("_", " ").capitalize(), "license": "CC0-1.0"}
        )
    (folder / "manifest.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="ascii")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "meshes")
