"""Writes examples/meshes: samples of what arrives in practice, each with something wrong with it but one.

    python examples/make_meshes.py [folder]

The same bytes every time, on every machine.
"""

from __future__ import annotations

import sys
from pathlib import Path

from samples import SAMPLES


def main(folder: Path) -> None:
    """Write every sample into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for sample in SAMPLES:
        for name, data in sample().items():
            (folder / name).write_bytes(data)
            print(f"{len(data):8d}  {name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "meshes")
