"""Why a picture is left out of a pack, and what to do about it."""

from __future__ import annotations

from enum import StrEnum

from casa_assets.errors import Rejected
from casa_assets.textures.packs.entry import RejectedPicture
from casa_assets.textures.packs.limits import MAX_ASPECT, MAX_FILE_BYTES, MAX_SIDE_PX, MIN_SIDE_PX


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


def rejection_error(reason: PictureRejection, message: str) -> Rejected:
    """The error to raise about a picture."""
    return Rejected(reason.value, message)


def rejection_row(source: str, error: Rejected) -> RejectedPicture:
    """The row of pack.json for an error that `rejection_error` made."""
    return RejectedPicture(
        source=source, code=error.code, message=error.message, fix=REMEDIES[PictureRejection(error.code)]
    )
