"""Recipe of a procedural texture: kind, seed and parameters."""

from __future__ import annotations

from casa_assets.model.asset.material import Positive
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.finish import Surface


class TextureRecipe(Record):
    """A row of registry/textures/<surface>.yaml, or of registry/skins/.

    Attributes:
        id: unique among all of them.
        surface: which set it belongs to; None for a skin of objects.
        kind: name of a kind of texture. seed: of its generator.
        tile_m: width and height of the picture in metres.
        substance: id in registry/substances.yaml.
        params: canonical JSON of the kind's own record.
    """

    id: Id
    surface: Surface | None = None
    kind: Id
    seed: int
    tile_m: tuple[Positive, Positive]
    substance: Id
    params: str = "{}"
