"""Files of an entry: asset.json with the asset and its certificate, reject.json of a rejected input, picture, models.

Two producers may be given one file: `ingest` makes a rigid asset of it, `articulate` one that opens. So an id is the
category and a word for the producer and its input, which finds all that it ever made of the input, under any category:

mug_e1b7e22aee                      ingest: the first 10 hex digits of the sha256 of the input
microwave_articulated_a39fd0c2b1    articulate: the same after an additional word
microwave_0c6e21fa83                a family: the first 10 hex digits of the digest of its numbers

A library may come from a stranger: its asset.json can name `../../x`, an absolute path or a link that leads elsewhere,
which would put files of this machine into pictures, exports and pages. Only regular files inside the entry's own folder
are opened.
"""

from __future__ import annotations

import copy
import hashlib
import io
import json
import os
import posixpath
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from lxml import etree
from PIL import Image
from pydantic import ValidationError

from casa_assets.errors import OutputError
from casa_assets.formats.mjcf import shapes
from casa_assets.model.asset.asset import Asset, Signature
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Files, Report
from casa_assets.model.record import Record
from casa_assets.model.source import Source

# The USD package holds every image; the MJCF has only those that MuJoCo draws.
IMAGES = "usd/textures"
SLOTS = ("base_color_texture", "metallic_roughness_texture", "normal_texture")
DIGITS = 10
# What stands before the digits in an id.
_WORDS = {"articulate": "articulated_"}
CERTIFICATE = "asset.json"
REFUSAL = "reject.json"
R = TypeVar("R", bound=Record)
_REMAKE = "remove its folder and run again"
PICTURE = "preview.png"
# Large enough for a sharp picture in a table, small enough for 3000 of them in one page.
THUMBNAIL_PX, THUMBNAIL_QUALITY = 160, 76
# The program writes pictures of 512 pixels along a side; larger ones come from elsewhere.
MAX_PX = 4096
_ADVICE = "remove the asset's folder, or fetch the library again"
# Attributes of MJCF that name a file to be loaded, and those that name a folder put in front of such names.
_FILE_ATTRIBUTES = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
_FOLDER_ATTRIBUTES = ("meshdir", "texturedir", "assetdir")


def manifest_of(asset: Asset) -> dict[str, Any]:
    """Return the JSON data of an asset; a mesh is written as `{"obj": path}`, and an image's `png` is its path."""
    data: dict[str, Any] = asset.model_dump(mode="json", exclude={"links": True, "materials": True})
    files = shapes.gather_meshes(asset).of
    data["links"] = []
    for link in asset.links:
        row = link.model_dump(mode="json", exclude={"visuals", "colliders"})
        row["visuals"] = [
            {"name": v.name, "material": v.material, "mesh": {"obj": files[v.name].path}}
            | ({} if v.label is None else {"label": v.label})
            for v in link.visuals
        ]
        row["colliders"] = []
        for c in link.colliders:
            keep = c.model_dump(mode="json", exclude={"shape": {"mesh"}})
            if c.name in files:
                keep["shape"]["mesh"] = {"obj": files[c.name].path}
            row["colliders"].append(keep)
        data["links"].append(row)
    data["materials"] = []
    for look in asset.materials:
        row = look.model_dump(mode="json", exclude=set(SLOTS))
        for slot in SLOTS:
            image = getattr(look, slot)
            row[slot] = None
            if image is not None:
                row[slot] = image.model_dump(mode="json", exclude={"png"})
                row[slot]["png"] = f"{IMAGES}/{image.file_name}"
        data["materials"].append(row)
    return data


def asset_from_manifest(data: dict[str, Any], folder: Path) -> Asset:
    """The asset that `manifest_of` described, its files read from `folder`. Raises OutputError."""

    def file(name: object, pointer: str) -> Path:
        return file_inside(folder, name, folder / "asset.json", f"asset/{pointer}")

    try:
        links, looks = copy.deepcopy(data["links"]), copy.deepcopy(data["materials"])
        for i, link in enumerate(links):
            for j, visual in enumerate(link["visuals"]):
                visual["mesh"] = read_obj(file(visual["mesh"]["obj"], f"links/{i}/visuals/{j}/mesh/obj"))
            for j, shape in enumerate(collider["shape"] for collider in link["colliders"]):
                if "mesh" in shape:
                    shape["mesh"] = read_obj(file(shape["mesh"]["obj"], f"links/{i}/colliders/{j}/shape/mesh/obj"))
        for i, look in enumerate(looks):
            for slot in SLOTS:
                if look[slot] is not None:
                    look[slot]["png"] = file(look[slot]["png"], f"materials/{i}/{slot}/png").read_bytes()
        return Asset.model_validate({**data, "links": links, "materials": looks})
    except (OSError, KeyError, TypeError, ValueError, ValidationError) as error:
        raise OutputError(str(folder), f"asset.json or a file that it names is damaged: {error}") from error


def read_obj(path: Path) -> Mesh:
    """An OBJ file as the MJCF writer writes it: one index for position, uv and normal. Raises ValueError, OSError."""
    rows: dict[str, list[list[float]]] = {"v": [], "vt": [], "vn": []}
    faces = []
    for line in path.read_text(encoding="ascii").splitlines():
        word, *values = line.split()
        if word == "f":
            faces.append([int(v.split("/")[0]) - 1 for v in values])
        elif word in rows:
            rows[word].append([float(v) for v in values])
    vertices, uv, normals = (np.array(rows[w], dtype=np.float32).astype(np.float64) for w in ("v", "vt", "vn"))
    return Mesh(vertices=vertices, faces=faces, uv=uv if len(uv) else None, normals=normals if len(normals) else None)


class Producer(StrEnum):
    """Producers of a library's entries."""

    INGEST = "ingest"
    ARTICULATE = "articulate"
    FAMILY = "family"


@dataclass(frozen=True)
class Identity:
    """A producer and the sha256 of what it was given: at most one entry of a library has them.

    Attributes:
        sha256: of the input; of a family's member, the digest of its numbers.
    """

    producer: Producer
    sha256: str

    @property
    def suffix(self) -> str:
        """End of the id after the category: a word for the producer, and digits of the input."""
        return f"{_WORDS.get(self.producer, '')}{self.sha256[:DIGITS]}"

    def asset_id(self, category: str) -> str:
        """The id under a category."""
        return f"{category}_{self.suffix}"

    def may_own(self, asset_id: str) -> bool:
        """True if an id can be that of this producer and input, under any category."""
        category, found, end = asset_id.rpartition(f"_{self.suffix}")
        return bool(found) and not end and not any(category.endswith(f"_{w}".rstrip("_")) for w in _WORDS.values())


def suffix_of(asset_id: str) -> str:
    """Return the end of an id, which identifies producer and input, as `Identity.suffix` gives it."""
    before, _, digits = asset_id.rpartition("_")
    for word in _WORDS.values():
        if f"{before}_".endswith(f"_{word}"):
            return f"{word}{digits}"
    return digits


class Summary(Record):
    """Numbers for tables: extents in metres, mass in kg, counts."""

    extents: tuple[float, float, float]
    mass: float
    colliders: int
    hull_vertices: int
    faces: int


@dataclass(frozen=True)
class MadeBy:
    """Producer of an entry, the key that it is kept under, and its stages and tools by version."""

    producer: Producer
    cache_key: str
    versions: dict[str, str]


class Certificate(Record):
    """Certificate of an asset: the part of asset.json besides the asset itself.

    Attributes:
        schema_version: of this file.
        asset_digest: of the Asset record, canonical.
        producer: what made the asset.
        cache_key: digest of everything that decided the result besides the source.
        versions: stages of the producer with their keys, and the packages that they use.
        report: every check that applies to this subject, with its number or why it did not apply or was not run.
        summary: numbers for tables.
        files: path -> sha256 of everything in the folder but asset.json.
        signature: compared with those of other assets; None if the asset has no visible geometry.
    """

    schema_version: Literal[2] = 2
    producer: Producer
    asset_digest: str
    cache_key: str
    versions: dict[str, str]
    report: Report
    summary: Summary
    files: dict[str, str]
    signature: Signature | None = None


@dataclass(frozen=True)
class Manifest:
    """asset.json of an accepted asset, read once: its certificate, and the asset as plain data."""

    folder: Path
    certificate: Certificate
    asset: Mapping[str, Any]

    @property
    def identity(self) -> Identity | None:
        """Producer and input of the asset; None if the file does not say."""
        try:
            return Identity(self.certificate.producer, str(self.asset["provenance"]["sha256"]))
        except (KeyError, TypeError):
            return None


class Refusal(Record):
    """Record of a rejected input in reject.json: the input, the reason, and what was known of it.

    Attributes:
        twin: folder, relative to the library, of the asset that it is a copy of; empty if it is no copy.
    """

    schema_version: Literal[2] = 2
    producer: Producer
    id: str
    code: str
    message: str
    category: str
    cache_key: str
    sha256: str
    source: Source
    report: Report | None = None
    twin: str = ""


def write_files(root: Path, files: Files) -> None:
    """Put files under a folder."""
    for path, data in files.entries.items():
        target = root / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)


def file_digests(root: Path) -> dict[str, str]:
    """Relative path -> sha256 of every file under a folder, sorted."""
    paths = sorted(p for p in root.rglob("*") if p.is_file())
    return {p.relative_to(root).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in paths}


def write_certificate(root: Path, asset: Asset, certificate: Certificate) -> None:
    """Write asset.json: the asset, with references to meshes and textures in the same folder, and its certificate."""
    _write_json(root / CERTIFICATE, {"asset": manifest_of(asset), "certificate": certificate.model_dump(mode="json")})


def write_refusal(root: Path, refusal: Refusal) -> None:
    """reject.json."""
    _write_json(root / REFUSAL, refusal.model_dump(mode="json"))


def read_certificate(folder: Path) -> Certificate:
    """The certificate of an accepted asset. Raises OutputError where the file is damaged."""
    return _certificate(folder, _json(folder / CERTIFICATE))


def read_manifest(folder: Path) -> Manifest:
    """All of asset.json of an accepted asset. Raises OutputError where the file is damaged."""
    data = _json(folder / CERTIFICATE)
    return Manifest(folder, _certificate(folder, data), _section(folder, data, "asset"))


def _certificate(folder: Path, data: Mapping[str, Any]) -> Certificate:
    return _record(Certificate, folder / CERTIFICATE, _section(folder, data, "certificate"))


def find_summary(folder: Path) -> Summary | None:
    """Return the numbers of the asset in a folder, or None if there is no asset, or no library has accepted it.

    Raises OutputError if asset.json is damaged.
    """
    path = folder / CERTIFICATE
    return read_certificate(folder).summary if path.is_file() and "certificate" in _json(path) else None


def is_whole(folder: Path, certificate: Certificate) -> bool:
    """True if every file that the certificate of an accepted asset names is there; its bytes are not compared."""
    return all((folder / name).is_file() for name in certificate.files)


def read_asset(folder: Path) -> Asset:
    """The whole Asset, meshes and textures included. Raises OutputError where a file is missing or damaged."""
    return asset_from_manifest(_section(folder, _json(folder / CERTIFICATE), "asset"), folder)


def read_refusal(folder: Path) -> Refusal:
    """Read the record of a rejected input. Raises OutputError where the file is damaged."""
    return _record(Refusal, folder / REFUSAL, _json(folder / REFUSAL))


def _section(folder: Path, data: Mapping[str, Any], name: str) -> dict[str, Any]:
    section = data.get(name)
    if not isinstance(section, dict):
        raise OutputError(str(folder / CERTIFICATE), f"holds no {name!r}; {_REMAKE}")
    return section


def _record(kind: type[R], path: Path, data: dict[str, Any]) -> R:
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(p) for p in first["loc"])
        raise OutputError(str(path), f"is damaged at {place}: {first['msg']}; {_REMAKE}") from error


def _write_json(path: Path, data: dict[str, Any]) -> None:
    text = json.dumps(data, sort_keys=True, indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _json(path: Path) -> dict[str, Any]:
    file_inside(path.parent, path.name, path, "the file itself")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise OutputError(str(path), f"cannot be read: {error}; {_REMAKE}") from error
    if not isinstance(data, dict):
        raise OutputError(str(path), f"is not a JSON object; {_REMAKE}")
    return data


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
