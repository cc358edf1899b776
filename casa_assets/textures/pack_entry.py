"""Records of texture packs (pack.yaml, pack.json): rows, ids, maps by file name, and why a picture is left out."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import PurePosixPath
from types import MappingProxyType
from typing import Annotated

from pydantic import Field, StringConstraints

from casa_assets.errors import Rejected
from casa_assets.model.asset.material import Positive
from casa_assets.model.issue import Code
from casa_assets.model.record import Id, Record, Sha256
from casa_assets.model.registry.rows import Surface

MIN_SIDE_PX = 512
MAX_SIDE_PX = 8192
MAX_ASPECT = 2.0  # long side over short side: a longer strip shows too little of a pattern
MAX_FILE_BYTES = 256 * 1024 * 1024


Text = Annotated[str, StringConstraints(max_length=4000)]
Share = Annotated[float, Field(ge=0, le=1)]
# A file right in the folder of its pack.
FileName = Annotated[str, StringConstraints(pattern=r"^[a-z0-9_]+\.png$", max_length=200)]
UNKNOWN = "unknown"


class PictureDescription(Record):
    """Description of a picture by a user: a row of pack.yaml, its `defaults`, or the flags; None if not given."""

    surface: Surface | None = Field(None, description="what it is for")
    tile_m: tuple[Positive, Positive] | None = Field(None, description="width and height of what the picture shows")
    licence: Text | None = Field(None, description="SPDX id, or the words of the licensor")
    prompt: Text | None = None
    generator: Text | None = None
    author: Text | None = None
    substance: Id | None = Field(None, description="id in registry/substances.yaml")
    roughness: Share | None = Field(None, description="mean over the surface")
    name: Text | None = Field(None, description="short name; None: the file name")

    def over(self, other: PictureDescription) -> PictureDescription:
        """This description, with what it leaves out taken from another."""
        stated = {name: getattr(self, name) for name in type(self).model_fields}
        return PictureDescription(**{k: getattr(other, k) if v is None else v for k, v in stated.items()})


class PackPicture(Record):
    """A picture of the pack."""

    id: Id = Field(description="`<pack>_<name>`")
    source: str = Field(description="file it came from, relative to its folder")
    source_sha256: Sha256 = Field(description="of the bytes of that file")
    surface: Surface
    substance: Id
    tile_m: tuple[Positive, Positive] = Field(description="width and height of one copy, after it was cut to tile")
    width_px: int = Field(ge=1, description="of the base colour")
    height_px: int = Field(ge=1, description="of the base colour")
    licence: str = Field(description="as given, or `unknown`")
    prompt: str
    generator: str
    author: str
    seam_before: float = Field(description="worst score of the border, see `textures.check.seam`")
    seam_after: float
    repaired: bool = Field(description="whether the border was repaired")
    given: dict[str, str] = Field(
        default_factory=dict, description="maps that it came with, and the file of each, relative as `source`"
    )
    derived: tuple[str, ...] = Field(description="maps computed from the colour, or normals from heights")
    files: tuple[FileName, FileName, FileName] = Field(description="base, normal and roughness, relative to the pack")
    sha256: tuple[Sha256, Sha256, Sha256] = Field(description="of each of the files")
    notes: tuple[str, ...] = Field((), description="what was done or is doubtful, one sentence each")
    faults: tuple[str, ...] = Field((), description="checks of textures that it fails, with their numbers")


class RejectedPicture(Record):
    """A picture that was left out."""

    source: str = Field(description="file, relative to its folder")
    code: Code = Field(description="such as `PCK005`")
    message: str = Field(description="what is wrong with it")
    fix: str = Field(description="what to do")


class SimilarPair(Record):
    """Two pictures of a pack that are nearly indistinguishable; both are kept."""

    first: Id
    second: Id
    distance: float


class Pack(Record):
    """pack.json."""

    id: Id = Field(description="name of the pack")
    version: int = Field(description="of the format of pack.json")
    pictures: tuple[PackPicture, ...] = Field((), description="by source")
    refused: tuple[RejectedPicture, ...] = ()
    alike: tuple[SimilarPair, ...] = Field((), description="nearly equal pairs, the closest first")
    ignored: tuple[str, ...] = Field((), description="files that are no pictures")


class PictureRejection(StrEnum):
    """Codes of the reasons."""

    UNREADABLE = "PCK001"
    NOT_A_PICTURE = "PCK002"
    BROKEN = "PCK003"
    TOO_LARGE = "PCK004"
    TOO_SMALL = "PCK005"
    TOO_LONG = "PCK006"
    TRANSPARENT = "PCK007"
    BLANK = "PCK008"
    DUPLICATE = "PCK009"
    SEAM = "PCK010"
    NOT_DESCRIBED = "PCK011"
    BAD_ROW = "PCK012"
    MISSING = "PCK013"
    NO_COLOR = "PCK015"


REMEDIES = {
    PictureRejection.UNREADABLE: "Replace it with a readable regular file inside the folder.",
    PictureRejection.NOT_A_PICTURE: ("Save it as PNG, JPEG or WebP, or as TIFF of 8 or 16 bits."),
    PictureRejection.BROKEN: "Download or generate it again; the file is cut or garbled.",
    PictureRejection.TOO_LARGE: (
        f"Scale it down to at most {MAX_SIDE_PX} pixels a side and at most {MAX_FILE_BYTES // 2**20} MiB."
    ),
    PictureRejection.TOO_SMALL: f"Generate it with {MIN_SIDE_PX} pixels a side or more; scaling it up adds nothing.",
    PictureRejection.TOO_LONG: f"Crop it so that the long side is at most {MAX_ASPECT:g} times the short one.",
    PictureRejection.TRANSPARENT: "Flatten it onto an opaque background.",
    PictureRejection.BLANK: "Generate it again; one colour from edge to edge is no texture.",
    PictureRejection.DUPLICATE: "Remove one of the two files.",
    PictureRejection.SEAM: "Generate it with a tiling option, or choose a picture with an even pattern.",
    PictureRejection.NOT_DESCRIBED: (
        "State the surface, tile size and licence in pack.yaml, or for all pictures with --surface, --tile, --licence."
    ),
    PictureRejection.BAD_ROW: "Correct that row of pack.yaml.",
    PictureRejection.MISSING: "Add the file, or remove its row.",
    PictureRejection.NO_COLOR: "Add the map of the colour (`..._color.jpg`) to the other maps.",
}


def rejection_row(source: str, error: Rejected) -> RejectedPicture:
    """The row of pack.json for a picture whose error has a code of PictureRejection."""
    fix = REMEDIES[PictureRejection(error.code)]
    return RejectedPicture(source=source, code=str(error.code), message=error.message, fix=fix)


_LONGEST = 64


def slug(text: str) -> str:
    """Lower case letters, digits and single underscores, starting with a letter; `picture` where nothing is left."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode("ascii").lower()
    words = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")[:_LONGEST].strip("_")
    if not words:
        return "picture"
    return words if words[0].isalpha() else f"p{words}"


def unique_ids(pack: str, names: Sequence[str]) -> tuple[str, ...]:
    """`<pack>_<name>` for each name, in order; what is there already gets the next free number."""
    taken: dict[str, None] = {}
    for name in names:
        wanted = f"{pack}_{slug(name)}"
        found, number = wanted, 2
        while found in taken:
            found, number = f"{wanted}_{number}", number + 1
        taken[found] = None
    return tuple(taken)


# Quantity that a map gives for a surface; its file's name ends with it. Normals have y up, as in OpenGL.
MapRole = StrEnum("MapRole", "COLOR NORMAL ROUGHNESS METALNESS HEIGHT")


_SUFFIX = re.compile(rf"^(.+)_({'|'.join(MapRole)})$")


@dataclass(frozen=True)
class MaterialFiles:
    """The files of one material."""

    name: str  # of the material, or of a picture that is a single file
    maps: Mapping[MapRole, str]  # role -> file


def name_and_role(path: str) -> tuple[str, MapRole] | None:
    """The material that a file is a map of, in lower case, and which map; None if its name does not say so."""
    found = _SUFFIX.match(PurePosixPath(path).stem.lower())
    return (found[1], MapRole(found[2])) if found else None


def group_maps(paths: Iterable[str]) -> tuple[MaterialFiles, ...]:
    """Materials that files belong to, in the order of their first files.

    Files of one folder are maps of one material if their names say so and at least two do. Any other file is a separate
    picture. A material without a colour map has no entry for it. `paths`: POSIX; sorted.
    """
    listed = list(paths)
    found: dict[tuple[str, str], dict[MapRole, str]] = {}
    for path in listed:
        if named := name_and_role(path):
            found.setdefault((_folder(path), named[0]), {}).setdefault(named[1], path)
    out: dict[str, MaterialFiles] = {}
    for path in listed:
        named = name_and_role(path)
        maps = found[_folder(path), named[0]] if named else {}
        if named and len(maps) > 1:
            out[next(iter(maps.values()))] = MaterialFiles(named[0], MappingProxyType(maps))
        else:
            out[path] = MaterialFiles(PurePosixPath(path).stem, MappingProxyType({MapRole.COLOR: path}))
    return tuple(out[path] for path in listed if path in out)


def _folder(path: str) -> str:
    return PurePosixPath(path).parent.as_posix()
