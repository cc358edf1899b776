"""Writes examples/appliances: static meshes of appliances, for `casa-assets articulate`.

    python examples/make_appliances.py [folder]

Each is a member of a family of this package with everything that says what moves taken away: no names, no joints, one
part for each material, doors closed. The same bytes every time.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import casa_assets as casa
from formats import Look, Part, glb, mtl, obj
from shapes import Array, Index, Surface


def static(asset: casa.Asset) -> list[Part]:
    """All that is seen of an asset, one part per material, every joint at zero. Metres, z up, front towards -y."""
    placed: dict[str, Any] = {}  # object_from_link of each link
    for link in asset.links:  # parents come before their children
        placed[link.name] = link.pose if link.parent is None else placed[link.parent] @ link.pose
    seen: dict[str, list[tuple[Array, Index]]] = {}
    for link in asset.links:
        for visual in link.visuals:
            points = placed[link.name].apply(visual.mesh.vertices)
            seen.setdefault(visual.material, []).append((points, visual.mesh.faces.astype(np.int64)))
    parts = []
    for number, material in enumerate(m for m in asset.materials if m.id in seen):
        points = np.concatenate([p for p, _ in seen[material.id]])
        starts = np.cumsum([0, *(len(p) for p, _ in seen[material.id])])
        faces = np.concatenate([f + s for (_, f), s in zip(seen[material.id], starts, strict=False)])
        r, g, b, _ = material.base_color
        look = Look(f"material{number}", (round(r, 3), round(g, 3), round(b, 3)), material.metallic, material.roughness)
        parts.append((_welded(points, faces), look))
    return parts


def _welded(points: Array, faces: Index) -> Surface:
    """Vertices at one place, to a hundredth of a millimetre, become one."""
    rounded, index = np.unique(np.round(points, 5) + 0.0, axis=0, return_inverse=True)
    joined = index.ravel()[faces]
    whole = (joined[:, 0] != joined[:, 1]) & (joined[:, 1] != joined[:, 2]) & (joined[:, 2] != joined[:, 0])
    return Surface(rounded, joined[whole], np.zeros((len(rounded), 2)))


def turned(parts: list[Part]) -> list[Part]:
    """The same with y up and the front towards +z, as glTF has it."""
    return [(Surface(s.vertices[:, [0, 2, 1]] * [1, 1, -1], s.faces, s.uv), look) for s, look in parts]


def main(folder: Path) -> None:
    """Write every appliance into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    microwave = static(casa.build("microwave", "steel"))
    files = {
        "microwave.obj": obj(microwave, "microwave.mtl"),
        "microwave.mtl": mtl([look for _, look in microwave]),
        "oven.glb": glb(turned(static(casa.build("wall_oven", "steel"))), "oven"),
    }
    for name, data in files.items():
        (folder / name).write_bytes(data)
        print(f"{len(data):8d}  {name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "appliances")
