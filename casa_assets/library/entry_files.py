"""Files that an entry of a library names: only regular files inside its own folder are opened.

A library may come from a stranger. Its asset.json can name `../../x`, an absolute path or a link that leads elsewhere,
and reading that would put files of this machine into pictures, exports and pages.
"""

from __future__ import annotations

import io
import os
import posixpath
import stat
from pathlib import Path

from lxml import etree
from PIL import Image

from casa_assets.errors import OutputError

PICTURE = "preview.png"
# Large enough for a sharp picture in a table, small enough for 3000 of them in one page.
THUMBNAIL_PX, THUMBNAIL_QUALITY = 160, 76
# The program writes pictures of 512 pixels along a side; larger ones come from elsewhere.
MAX_PX = 4096
_ADVICE = "remove the asset's folder, or fetch the library again"
# Attributes of MJCF that name a file to be loaded, and those that name a folder put in front of such names.
_FILE_ATTRIBUTES = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
_FOLDER_ATTRIBUTES = ("meshdir", "texturedir", "assetdir")


def file_inside(folder: Path, name: object, said_by: Path, pointer: str) -> Path:
    """The regular file that an entry names, relative to its folder.

    Args:
        folder: of the entry. name: as the entry says it.
        said_by: file that names it. pointer: place in that file, such as `links/0/visuals/1/mesh`.
    Raises:
        OutputError: the name is no relative path inside the folder, leads out of it by a link, or is no regular file;
            it says which file names it, and where.
    """
    shown = repr(name)[:120]
    if not isinstance(name, str) or not name or "\0" in name or "\\" in name:
        raise OutputError(str(said_by), f"{pointer}: {shown} is no name of a file; {_ADVICE}")
    plain = posixpath.normpath(name)
    if posixpath.isabs(name) or plain == ".." or plain.startswith("../"):
        raise OutputError(str(said_by), f"{pointer}: {shown} leaves the folder of the asset; {_ADVICE}")
    path = folder / name
    if plain == name and _is_plain(str(folder), plain):
        return path
    real = os.path.realpath(path)
    if not Path(real).is_relative_to(os.path.realpath(folder)):
        raise OutputError(str(said_by), f"{pointer}: {shown} is a link that leaves the folder of the asset; {_ADVICE}")
    try:
        is_regular = stat.S_ISREG(Path(real).stat().st_mode)
    except OSError as error:
        raise OutputError(
            str(said_by), f"{pointer}: {shown} is missing or damaged: {error.strerror}; {_ADVICE}"
        ) from error
    if not is_regular:
        raise OutputError(str(said_by), f"{pointer}: {shown} is no regular file; {_ADVICE}")
    return path


def _is_plain(folder: str, name: str) -> bool:
    """True for a regular file in a folder, or in folders in it, with no link on the way; no path is resolved for it."""
    *places, last = name.split("/")
    try:
        for place in places:
            folder = f"{folder}/{place}"
            if not stat.S_ISDIR(os.lstat(folder).st_mode):
                return False
        return stat.S_ISREG(os.lstat(f"{folder}/{last}").st_mode)
    except OSError:
        return False  # what is wrong is told by who looks closely


def picture_of(folder: Path) -> bytes:
    """PNG of an entry; empty where it has none. Raises OutputError where the file is damaged or a link out of it."""
    path = folder / PICTURE
    if not os.path.lexists(path):
        return b""
    data = file_inside(folder, PICTURE, path, "the file itself").read_bytes()
    try:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as image:
            width, height = image.size
            image.verify()
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise OutputError(str(path), f"is no picture: {error}; {_ADVICE}") from error
    if max(width, height) > MAX_PX:
        raise OutputError(str(path), f"has {width} x {height} pixels, more than {MAX_PX} along a side; {_ADVICE}")
    return data


def thumbnail_of(folder: Path) -> bytes:
    """The picture of an entry at 160 pixels, WebP; empty where it has none. Raises OutputError as `picture_of`."""
    png = picture_of(folder)
    if not png:
        return b""
    with Image.open(io.BytesIO(png)) as opened:
        picture = opened.convert("RGB")
    picture.thumbnail((THUMBNAIL_PX, THUMBNAIL_PX), Image.Resampling.LANCZOS, reducing_gap=2.0)
    out = io.BytesIO()
    picture.save(out, format="WEBP", quality=THUMBNAIL_QUALITY, method=2)
    return out.getvalue()


def checked_model(model: Path) -> Path:
    """The MJCF file of an entry, once it is sure that all that it loads lies in the entry's folder.

    Raises:
        OutputError: it cannot be read, includes another file, or names one outside its folder.
    """
    folder = model.parent
    file_inside(folder, model.name, model, "the file itself")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root = etree.parse(model, parser).getroot()
    except (OSError, etree.XMLSyntaxError) as error:
        raise OutputError(str(model), f"cannot be read: {error}; {_ADVICE}") from error
    for compiler in root.iter("compiler"):
        for word in _FOLDER_ATTRIBUTES:
            if word in compiler.attrib:
                raise OutputError(str(model), f"compiler/{word}: models of a library have none; {_ADVICE}")
    for element in root.iter(etree.Element):
        if element.tag == "include":
            raise OutputError(str(model), f"line {element.sourceline}: includes another file; {_ADVICE}")
        for word in _FILE_ATTRIBUTES:
            if word in element.attrib:
                file_inside(folder, element.get(word), model, f"line {element.sourceline}, {element.tag}/{word}")
    return model
