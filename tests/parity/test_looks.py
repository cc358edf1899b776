"""What an input shows is what both of our files show: mirrors, moved textures, vertex colours, materials, glass."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from casa_assets.checks.readers.usd_facts import missing_importer
from casa_assets.core.numeric import Floats
from casa_assets.model.source import Up
from casa_assets.show.stills.still import render, render_model
from casa_assets.show.stills.studio import View
from tests.support.asset.packages import written
from tests.support.mesh.mesh_files import QUARTERS, Gltf, load_bytes, png
from tests.support.mesh.raw_models import built

VIEW = View(size_px=192, passes=6)
# Blocks that pictures are compared in, and what their colours, 0..255, may differ by in the mean and at worst.
BLOCKS = 12
SAME = (0.5, 3.0)
# MuJoCo reads USD without a colour curve or opacity, so colours here are full or none and glass is a hue; a raw
# mesh with vertex colours shows them as they are, and ours as the pixels of a texture.
ALIKE = (16.0, 66.0)
DRAWN_OTHERWISE = ("vertex colours", "glass")

# A wedge: no mirror image of it is the thing itself. Corners in glTF axes, y up, front to +z.
WEDGE = [(0, 0, 0), (2, 0, 0), (2, 0, 1), (0, 0, 1), (0, 1.6, 0), (2, 0.5, 0), (2, 0.5, 1), (0, 1.6, 1)]
SIDES = [(3, 2, 6, 7), (1, 0, 4, 5), (0, 3, 7, 4), (2, 1, 5, 6), (7, 6, 5, 4), (0, 1, 2, 3)]
POINTS, CORNERS = [WEDGE[k] for side in SIDES for k in side], [(0, 1), (1, 1), (1, 0), (0, 0)]


def wedge() -> Gltf:
    """A wedge of six sides, each with the whole picture."""
    made = Gltf(POINTS, [4 * i + k for i in range(6) for k in (0, 1, 2, 0, 2, 3)])
    made.attributes["TEXCOORD_0"] = made.add(np.array(CORNERS * 6, dtype="<f4"), "VEC2")
    return made


def pictured(**mapping: object) -> Gltf:
    """The wedge with four colours in the corners of each side, texture moved as told."""
    made = wedge()
    made.paint(png(np.kron(QUARTERS, np.ones((16, 16, 1))).astype(np.uint8)))
    info = {"index": 0, "extensions": {"KHR_texture_transform": mapping}} if mapping else {"index": 0}
    made.document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": info, "metallicFactor": 0.0}}]
    return made


def mirrored() -> Gltf:
    made = pictured()
    made.node |= {"scale": [-1, 1, 1], "translation": [2, 0, 0]}
    return made


def paint(color: tuple[float, ...], **more: object) -> dict[str, object]:
    return {"pbrMetallicRoughness": {"baseColorFactor": color, "metallicFactor": 0.0}, **more}


def colored() -> Gltf:
    """Vertex colours: red below, blue above."""
    made = wedge()
    colors = np.array([(0, 0, 1) if high > 0 else (1, 0, 0) for _, high, _ in POINTS], dtype="<f4")
    made.attributes["COLOR_0"] = made.add(colors, "VEC3")
    return made


def several() -> Gltf:
    """A side of each material: red, green, blue, and the rest yellow."""
    made = wedge()
    primitives = []
    for k, sides in enumerate(([0], [2], [4], [1, 3, 5])):
        corners = [4 * side + corner for side in sides for corner in (0, 1, 2, 0, 2, 3)]
        indices = made.add(np.array(corners, dtype="<u2"), "SCALAR")
        primitives.append({"attributes": made.attributes, "indices": indices, "material": k})
    made.document["meshes"] = [{"primitives": primitives}]
    made.document["materials"] = [paint((*c, 1)) for c in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0))]
    return made


def glass() -> Gltf:
    """A blue pane all around a red wedge."""
    made = several()
    made.document["materials"] = [paint((0, 0, 1, 0.4), alphaMode="BLEND"), *[paint((1, 0, 0, 1))] * 3]
    return made


LOOKS = {
    "picture": pictured(),
    "moved": pictured(offset=[0.5, 0.0], scale=[0.5, 0.5]),
    "turned": pictured(offset=[0.0, 1.0], rotation=np.pi / 2),
    "mirrored": mirrored(),
    "vertex colours": colored(),
    "materials": several(),
    "glass": glass(),
}


def blocks(picture: bytes) -> Floats:
    """(BLOCKS, BLOCKS, 3) mean colours of a picture."""
    with Image.open(io.BytesIO(picture)) as image:
        small = image.convert("RGB").resize((BLOCKS, BLOCKS), Image.Resampling.BOX)
        return np.asarray(small, dtype=np.float64)


@pytest.mark.parametrize("name", LOOKS)
def test_both_files_show_what_the_input_shows(name: str, tmp_path: Path) -> None:
    model = load_bytes("x.glb", LOOKS[name].glb())
    asset, _ = built(model, "boxed_food")
    package = written(asset, tmp_path)
    before = blocks(render_model(model.replace(up=Up.Y), VIEW))
    limits = ALIKE if name in DRAWN_OTHERWISE else SAME
    # MuJoCo draws both, and its reader of USD is not there for every Python.
    for file in (package.mjcf,) if missing_importer() else (package.mjcf, package.usd):
        gap = np.abs(before - blocks(render(file, VIEW))).mean(axis=2)
        assert gap.mean() < limits[0]
        assert gap.max() < limits[1]
