"""Objects out of numbers: where a hand takes them, their split, and checks of their labels."""

from __future__ import annotations

import base64
import io
import json
import math
from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image

from casa_assets import registry
from casa_assets.asset.family import Params
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.checks.objects.members import ObjectMember
from casa_assets.checks.run import run
from casa_assets.checks.table import objects
from casa_assets.core.numeric import Floats
from casa_assets.mesh.grasps import choose_grasps, grasp_site
from casa_assets.mesh.topology import weld
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Grasp
from casa_assets.model.asset.provenance import split_of
from casa_assets.model.issue import Report
from casa_assets.model.registry.category import Category
from casa_assets.registry.plugins.textures import texture_kinds
from casa_assets.textures.canvas import PrintedLine
from casa_assets.textures.run.recipes import skins

# Loose objects --------------------------------------------------------------------------------------------------------
# Complete an object out of numbers: add sites where a hand can take it, and its split for training or for testing.

# Two members have the same proportions where the logarithms of these fall into one step of this width: about a sixth.
PROPORTION_STEP = 0.15


def complete(asset: Asset, params: Params, category: Category, opening_m: float) -> Asset:
    """The object with its split, and with a site `grasp_<feature>` for each way in which a hand can take it.

    Args:
        params: its numbers. opening_m: largest opening of the gripper.
    """
    split = split_of(shape_digest(asset, params))
    grasps = tuple(grasp_site(grasp, np.zeros(3)) for grasp in _grasps(asset, category, opening_m))
    return asset.replace(labels=asset.labels.replace(split=split), sites=(*asset.sites, *grasps))


def shape_digest(asset: Asset, params: Params) -> str:
    """64 hex digits that members of a category share where they have the same design and about the same proportions.

    Colours, labels and what is random in a surface have no part in it, and neither has the size.
    """
    x, y, z = (float(side) for side in np.ptp(asset.bounds, axis=0))
    proportions = [round(math.log(ratio) / PROPORTION_STEP) for ratio in (y / x, z / x)]
    return digest_of("shape", asset.labels.category, params.design, proportions)


def _grasps(asset: Asset, category: Category, opening_m: float) -> tuple[Grasp, ...]:
    """Grasps of the root link: what takes a lid lifts the lid and not the pot."""
    root = asset.root
    parts = [visual.mesh for visual in root.visuals]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in parts[:-1])])
    points, point_of_vertex = weld(np.concatenate([mesh.vertices for mesh in parts]).astype(np.float64))
    faces = np.concatenate([mesh.faces.astype(np.int64) + start for mesh, start in zip(parts, starts, strict=True)])
    return choose_grasps(points, point_of_vertex[faces], root.inertial.center_of_mass, category, opening_m)


# Member checks --------------------------------------------------------------------------------------------------------
# Check a member of a category of objects: its sides, and the lines that are printed on its labels.


def check_member(asset: Asset, category: Category, cache: Path) -> Report:
    """The report of the checks on members of objects.

    Args:
        cache: folder of the store that keeps where lines are printed.
    """
    member = ObjectMember(asset, category, printed_lines(asset, cache))
    records = registry.load()
    return run(member, asset.id, records.limits, records.waived(asset.id), objects.ROWS)


def printed_lines(asset: Asset, cache: Path) -> dict[str, tuple[PrintedLine, ...]]:
    """Return the printed lines of each material with a label, by its id: brand and first word, placed in its picture.

    Args:
        cache: folder of the store that keeps them.
    """
    found = {}
    for material in asset.materials:
        recipe, picture = skins().get(material.id), material.base_color_texture
        kind = None if recipe is None else texture_kinds().get(recipe.kind)
        if recipe is not None and picture is not None and kind is not None and kind.printed_lines is not None:
            store, size = Store(cache / "printed_lines", is_optional=True), (picture.height_px, picture.width_px)
            key = digest_of("printed_lines", key_of(kind.printed_lines), recipe.digest, size)
            kept = store.get(key)
            if kept is None:
                made = kind.printed_lines(kind.params.from_json(recipe.params), size)
                rows = [
                    {"text": x.text, "runs_upwards": x.runs_upwards, "png": _png(np.asarray(x.cover))} for x in made
                ]
                kept = json.dumps(rows, sort_keys=True).encode()
                store.put(key, kept)
            found[material.id] = _read(kept)
    return found


@lru_cache(maxsize=64)
def _read(kept: bytes) -> tuple[PrintedLine, ...]:
    found = []
    for row in json.loads(kept):
        with Image.open(io.BytesIO(base64.b64decode(row["png"]))) as image:
            found.append(PrintedLine(row["text"], np.asarray(image) / 255.0, row["runs_upwards"]))
    return tuple(found)


def _png(cover: Floats) -> str:
    out = io.BytesIO()
    Image.fromarray(np.rint(255 * cover).astype(np.uint8)).save(out, "PNG")
    return base64.b64encode(out.getvalue()).decode()
