"""Asset <-> JSON that a person can read: meshes and images are separate files next to it, named and not copied."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from casa_assets.errors import OutputError
from casa_assets.formats.mjcf import shapes
from casa_assets.library.entry_files import file_inside
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Mesh

# The USD package holds every image; the MJCF has only those that MuJoCo draws.
IMAGES = "usd/textures"
SLOTS = ("base_color_texture", "metallic_roughness_texture", "normal_texture")


def manifest_of(asset: Asset) -> dict[str, Any]:
    """Return the JSON data of an asset; a mesh is written as `{"obj": path}`, and an image's `png` is its path."""
    data: dict[str, Any] = asset.model_dump(mode="json", exclude={"links": True, "materials": True})
    files = shapes.gather_meshes(asset).of
    data["links"] = []
    for link in asset.links:
        row = link.model_dump(mode="json", exclude={"visuals", "colliders"})
        row["visuals"] = [
            {"name": v.name, "material": v.material, "mesh": {"obj": files[v.name].path}}
            | ({} if v.label is None else {"label": v.label})
            for v in link.visuals
        ]
        row["colliders"] = []
        for c in link.colliders:
            keep = c.model_dump(mode="json", exclude={"shape": {"mesh"}})
            if c.name in files:
                keep["shape"]["mesh"] = {"obj": files[c.name].path}
            row["colliders"].append(keep)
        data["links"].append(row)
    data["materials"] = []
    for look in asset.materials:
        row = look.model_dump(mode="json", exclude=set(SLOTS))
        for slot in SLOTS:
            image = getattr(look, slot)
            row[slot] = None
            if image is not None:
                row[slot] = image.model_dump(mode="json", exclude={"png"})
                row[slot]["png"] = f"{IMAGES}/{image.file_name}"
        data["materials"].append(row)
    return data


def asset_from_manifest(data: dict[str, Any], folder: Path) -> Asset:
    """The asset that `manifest_of` described, its files read from `folder`.

    Raises:
        OutputError: a file lies outside of the folder, is missing, or does not hold what it should.
    """

    def file(name: object, pointer: str) -> Path:
        return file_inside(folder, name, folder / "asset.json", f"asset/{pointer}")

    try:
        links, looks = copy.deepcopy(data["links"]), copy.deepcopy(data["materials"])
        for i, link in enumerate(links):
            for j, visual in enumerate(link["visuals"]):
                visual["mesh"] = read_obj(file(visual["mesh"]["obj"], f"links/{i}/visuals/{j}/mesh/obj"))
            for j, shape in enumerate(collider["shape"] for collider in link["colliders"]):
                if "mesh" in shape:
                    shape["mesh"] = read_obj(file(shape["mesh"]["obj"], f"links/{i}/colliders/{j}/shape/mesh/obj"))
        for i, look in enumerate(looks):
            for slot in SLOTS:
                if look[slot] is not None:
                    look[slot]["png"] = file(look[slot]["png"], f"materials/{i}/{slot}/png").read_bytes()
        return Asset.model_validate({**data, "links": links, "materials": looks})
    except (OSError, KeyError, TypeError, ValueError, ValidationError) as error:
        raise OutputError(str(folder), f"asset.json or a file that it names is damaged: {error}") from error


def read_obj(path: Path) -> Mesh:
    """An OBJ file as the MJCF writer writes it: one index for position, uv and normal. Raises ValueError, OSError."""
    rows: dict[str, list[list[float]]] = {"v": [], "vt": [], "vn": []}
    faces = []
    for line in path.read_text(encoding="ascii").splitlines():
        word, *values = line.split()
        if word == "f":
            faces.append([int(v.split("/")[0]) - 1 for v in values])
        elif word in rows:
            rows[word].append([float(v) for v in values])
    vertices, uv, normals = (np.array(rows[w], dtype=np.float32).astype(np.float64) for w in ("v", "vt", "vn"))
    return Mesh(vertices=vertices, faces=faces, uv=uv if len(uv) else None, normals=normals if len(normals) else None)
