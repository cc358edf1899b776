"""Check a member of a category of objects: its sides, and the lines that are printed on its labels."""

from __future__ import annotations

import base64
import io
import json
from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image

from casa_assets import registry
from casa_assets.checks.objects.member import ObjectMember, PrintedLine
from casa_assets.checks.run import run
from casa_assets.checks.table import objects
from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Texture
from casa_assets.model.issue import Report
from casa_assets.model.registry.category import Category
from casa_assets.model.registry.texture_recipe import TextureRecipe
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.textures.recipes import skins
from casa_assets.textures.kinds.objects.label import LABEL, Label
from casa_assets.textures.kinds.objects.printed_lines import lines_in_picture


def check_member(asset: Asset, category: Category, cache: Path) -> Report:
    """The report of the checks on members of objects.

    Args:
        cache: folder of the store that keeps where lines are printed.
    """
    member = ObjectMember(asset, category, printed_lines(asset, cache))
    records = registry.load()
    return run(member, asset.id, records.limits, records.waived(asset.id), objects.ROWS)


def printed_lines(asset: Asset, cache: Path) -> dict[str, tuple[PrintedLine, ...]]:
    """Id of each material with a label -> the brand and the first word where they stand in its picture.

    Args:
        cache: folder of the store that keeps them.
    """
    found = {}
    for material in asset.materials:
        recipe, picture = skins().get(material.id), material.base_color_texture
        if recipe is not None and recipe.kind == LABEL.name and picture is not None:
            found[material.id] = _lines(recipe, picture, cache)
    return found


def _lines(recipe: TextureRecipe, picture: Texture, cache: Path) -> tuple[PrintedLine, ...]:
    store, size = Store(cache / "printed_lines", is_optional=True), (picture.height_px, picture.width_px)
    key = digest_of("printed_lines", key_of(lines_in_picture), recipe.digest, size)
    kept = store.get(key)
    if kept is None:
        made = lines_in_picture(Label.from_json(recipe.params), size)
        rows = [{"text": x.text, "runs_upwards": x.runs_upwards, "png": _png(np.asarray(x.cover))} for x in made]
        kept = json.dumps(rows, sort_keys=True).encode()
        store.put(key, kept)
    return _read(kept)


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
