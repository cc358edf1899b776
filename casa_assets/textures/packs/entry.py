"""Records of texture packs: rows of pack.yaml, and pack.json."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from casa_assets.model.asset.material import Positive
from casa_assets.model.issue import Code
from casa_assets.model.record import Id, Record, Sha256
from casa_assets.model.registry.finish import Surface

Text = Annotated[str, StringConstraints(max_length=4000)]
Share = Annotated[float, Field(ge=0, le=1)]
# A file right in the folder of its pack.
FileName = Annotated[str, StringConstraints(pattern=r"^[a-z0-9_]+\.png$", max_length=200)]
UNKNOWN = "unknown"


class PictureDescription(Record):
    """Description of a picture by a user: a row of pack.yaml, its `defaults`, or the flags; None if not given.

    Attributes:
        surface: what it is for.
        tile_m: width and height in metres of the surface that the picture shows.
        licence: SPDX id, or the words of the licensor.
        prompt, generator, author: how and by whom it was made.
        substance: id in registry/substances.yaml.
        roughness: 0..1, mean over the surface.
        name: short name; by default the file name.
    """

    surface: Surface | None = None
    tile_m: tuple[Positive, Positive] | None = None
    licence: Text | None = None
    prompt: Text | None = None
    generator: Text | None = None
    author: Text | None = None
    substance: Id | None = None
    roughness: Share | None = None
    name: Text | None = None

    def over(self, other: PictureDescription) -> PictureDescription:
        """This description, with what it leaves out taken from another."""
        said = {name: getattr(self, name) for name in type(self).model_fields}
        return PictureDescription(**{k: getattr(other, k) if v is None else v for k, v in said.items()})


class PackPicture(Record):
    """A picture of the pack.

    Attributes:
        id: `<pack>_<name>`.
        source: file it came from, relative to its folder; `source_sha256` is that of its bytes.
        surface, substance: what it is for, what it is made of.
        tile_m: width and height in metres of one copy, after it was cut to tile.
        width_px, height_px: of the base colour.
        licence, prompt, generator, author: as they were given, `unknown` where nothing was said.
        seam_before, seam_after: worst score of the border, see `textures.seam`.
        repaired: whether the border was repaired.
        given: maps that it came with (normal, roughness, metalness, height) -> the file of each, relative as `source`.
        derived: maps that were computed from the colour, or normals from heights, and are therefore guesses.
        files: base, normal and roughness, relative to the pack; sha256 of each in the same order.
        notes: what was done or is doubtful, one sentence each.
        faults: checks of textures that it fails, with their numbers; `textures check` fails on it too.
    """

    id: Id
    source: str
    source_sha256: Sha256
    surface: Surface
    substance: Id
    tile_m: tuple[Positive, Positive]
    width_px: Annotated[int, Field(ge=1)]
    height_px: Annotated[int, Field(ge=1)]
    licence: str
    prompt: str
    generator: str
    author: str
    seam_before: float
    seam_after: float
    repaired: bool
    given: dict[str, str] = Field(default_factory=dict)
    derived: tuple[str, ...]
    files: tuple[FileName, FileName, FileName]
    sha256: tuple[Sha256, Sha256, Sha256]
    notes: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()


class RejectedPicture(Record):
    """A picture that was left out.

    Attributes:
        source: file, relative to its folder.
        code: such as `PCK005`.
        message: what is wrong with it.
        fix: what to do.
    """

    source: str
    code: Code
    message: str
    fix: str


class SimilarPair(Record):
    """Two pictures of a pack that are nearly indistinguishable; both are kept."""

    first: Id
    second: Id
    distance: float


class Pack(Record):
    """pack.json.

    Attributes:
        id: name of the pack. version: of the format of pack.json.
        pictures, refused: by source.
        alike: nearly equal pairs, the closest first.
        ignored: files that are no pictures.
    """

    id: Id
    version: int
    pictures: tuple[PackPicture, ...] = ()
    refused: tuple[RejectedPicture, ...] = ()
    alike: tuple[SimilarPair, ...] = ()
    ignored: tuple[str, ...] = ()
