"""A plug-in for tests, as text: a family, a form of objects, a check, a kind of texture, a source and an exporter."""

from __future__ import annotations

PLUGIN = '''
from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from pydantic import Field

import casa_assets as casa
from casa_assets.ext.checks import Check, Measurement, at_most
from casa_assets.ext.families import Family, FinishId, Params
from casa_assets.ext.plugins import Plugin
from casa_assets.ext.records import Base, Record, Severity
from casa_assets.ext.solids import ROOT, AssetBuilder, board
from casa_assets.ext.textures import Canvas, Layers, TextureKind


class Plinth(Params):
    """A block of wood."""

    width: float = Field(0.3, ge=0.1, le=0.6, description="m")
    face: FinishId = "oak_natural"


def add_plinth(builder: AssetBuilder, p: Plinth) -> None:
    if p.width == 0.13:
        raise ValueError("thirteen brings bad luck")
    builder.add(ROOT, board((0, 0, 0), (p.width, 0.2, 0.1)), p.face, label="body")


FAMILY = Family(
    "plinth", Plinth, add_plinth, sample=lambda rng, available: Plinth(width=round(float(rng.uniform(0.2, 0.5)), 3)),
    presets={"oak": Plinth(), "unlucky": Plinth(width=0.13)},
)


class Coaster(Params):
    """A square coaster."""

    width: float = Field(0.1, ge=0.05, le=0.2, description="m")
    face: FinishId = "cork_plain"


def add_coaster(builder: AssetBuilder, p: Coaster) -> None:
    builder.add(ROOT, board((0, 0, 0), (p.width, p.width, 0.006)), p.face, label="body")


FORM = Family("square", Coaster, add_coaster, base=Base.FREE)


def parts(asset: casa.Asset, limit: float) -> Measurement:
    return at_most(float(len(asset.links)), limit, "links", "has more links than people like")


CHECK = Check(
    "TST001", "Few links", Severity.ERROR, casa.Asset, parts, "most_links", "",
    "An asset has at most {limit:g} links; leave some out.",
)


class Chequers(Record):
    """Two colours, 0..1 grey."""

    dark: float = 0.2
    light: float = 0.8


def paint(p: Chequers, canvas: Canvas, rng: np.random.Generator) -> Layers:
    if p.dark > p.light:
        raise RuntimeError("dark is lighter than light")
    rows, columns = np.indices(canvas.size_px)
    height, width = canvas.size_px
    grey = np.where((4 * rows // height + 4 * columns // width) % 2, p.dark, p.light)
    return Layers.of(np.repeat(grey[..., None], 3, axis=2), np.zeros_like(grey), np.full_like(grey, 0.6))


class Depot:
    """Writes one box, or fails."""

    scheme = "depot"

    def fetch(self, address: str, folder: Path) -> None:
        if address.endswith("gone"):
            raise OSError("the depot is shut")
        rows = [(x, y, z) for x in (0, 0.19) for y in (0, 0.29) for z in (0, 0.06)]
        faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
        lines = [f"v {x} {y} {z}" for x, y, z in rows] + ["f " + " ".join(map(str, face)) for face in faces]
        (folder / "cereal_box.obj").write_text("\\n".join(lines) + "\\n")


class Blocks:
    """Sizes as JSON."""

    name, about = "blocks", "The mass of each asset, as JSON."

    def write(self, asset: casa.Asset) -> Mapping[str, bytes]:
        return {"block.json": json.dumps({"id": asset.id, "mass": round(asset.mass, 6)}).encode()}


PLUGIN = Plugin(
    name="testing", version="1.0", families=(FAMILY,), forms=(FORM,), checks=(CHECK,), limits={"most_links": 40.0},
    texture_kinds=(TextureKind("chequers", Chequers, paint),), sources=(Depot(),), exporters=(Blocks(),),
)
'''

PROJECT = {
    "plugins/testing.py": PLUGIN,
    "fixtures.yaml": "plinth: {parent: kitchenware, longest_m: [0.1, 0.3, 0.6], mass_kg: [0.5, 3, 10], "
    "shape: [1, 0.6, 0.3], upright: stands, build: solid, substance: wood}\n",
    "objects/ours.yaml": "coaster:\n  form: square\n  about: Square coasters of cork.\n"
    "  sample:\n    width: {range: [0.09, 0.11], step: 0.001}\n    face: cork_plain\n",
    "textures/floor.yaml": "chess: {kind: chequers, seed: 1, tile_m: [1, 1], substance: stone, params: {}}\n"
    "bad_chess: {kind: chequers, seed: 1, tile_m: [1, 1], substance: stone, params: {dark: 0.9}}\n",
    "families/plinth.yaml": "presets:\n  wide: {width: 0.5}\n",
}
