"""Why a picture is left out of a pack, and what to do about it."""

from __future__ import annotations

from enum import StrEnum

from casa_assets.errors import Rejected
from casa_assets.textures.packs.entry import RefusedPicture


class PackFault(StrEnum):
    """Codes of refusals."""

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


REMEDIES = {
    PackFault.UNREADABLE: "Put a regular file that may be read there, inside the folder.",
    PackFault.NOT_A_PICTURE: "Save it as PNG, JPEG or WebP.",
    PackFault.BROKEN: "Download or generate it again; the file is cut or garbled.",
    PackFault.TOO_LARGE: "Scale it down to 8192 pixels a side or less.",
    PackFault.TOO_SMALL: "Generate it with 512 pixels a side or more; scaling it up adds nothing.",
    PackFault.TOO_LONG: "Cut it to a square, or to twice as long as wide at most.",
    PackFault.TRANSPARENT: "Lay it on an opaque ground.",
    PackFault.BLANK: "Generate it again; one colour from edge to edge is no texture.",
    PackFault.DUPLICATE: "Remove one of both files.",
    PackFault.SEAM: "Generate it with a tiling option, or choose a picture with an even pattern.",
    PackFault.NOT_DESCRIBED: "Say it in pack.yaml, or for all pictures by --surface, --tile and --licence.",
    PackFault.BAD_ROW: "Mend that row of pack.yaml.",
    PackFault.MISSING: "Add the file, or remove its row from pack.yaml.",
}


def refuse(fault: PackFault, message: str) -> Rejected:
    """The error to raise about a picture."""
    return Rejected(fault.value, message)


def refused(source: str, error: Rejected) -> RefusedPicture:
    """The row of pack.json for an error that `refuse` made."""
    return RefusedPicture(source=source, code=error.code, message=error.message, mend=REMEDIES[PackFault(error.code)])
