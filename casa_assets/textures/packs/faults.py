"""Why a picture is left out of a pack, and what to do about it."""

from __future__ import annotations

from enum import StrEnum

from casa_assets.errors import Rejected
from casa_assets.textures.packs.entry import Refused


class Fault(StrEnum):
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


MEND = {
    Fault.UNREADABLE: "Put a regular file that may be read there, inside the folder.",
    Fault.NOT_A_PICTURE: "Save it as PNG, JPEG or WebP.",
    Fault.BROKEN: "Download or generate it again; the file is cut or garbled.",
    Fault.TOO_LARGE: "Scale it down to 8192 pixels a side or less.",
    Fault.TOO_SMALL: "Generate it with 512 pixels a side or more; scaling it up adds nothing.",
    Fault.TOO_LONG: "Cut it to a square, or to twice as long as wide at most.",
    Fault.TRANSPARENT: "Lay it on an opaque ground.",
    Fault.BLANK: "Generate it again; one colour from edge to edge is no texture.",
    Fault.DUPLICATE: "Remove one of both files.",
    Fault.SEAM: "Generate it with a tiling option, or choose a picture with an even pattern.",
    Fault.NOT_DESCRIBED: "Say it in pack.yaml, or for all pictures by --surface, --tile and --licence.",
    Fault.BAD_ROW: "Mend that row of pack.yaml.",
    Fault.MISSING: "Add the file, or remove its row from pack.yaml.",
}


def refuse(fault: Fault, message: str) -> Rejected:
    """The error to raise about a picture."""
    return Rejected(fault.value, message)


def refused(source: str, error: Rejected) -> Refused:
    """The row of pack.json for an error that `refuse` made."""
    return Refused(source=source, code=error.code, message=error.message, mend=MEND[Fault(error.code)])
