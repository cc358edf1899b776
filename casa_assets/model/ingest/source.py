"""Inputs of ingest: the description that the source gives of a mesh, its bytes, and the parts read from them."""

from __future__ import annotations

import hashlib
from enum import StrEnum
from functools import cached_property
from typing import Annotated

from pydantic import Field

from casa_assets.model.asset.material import Material
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.provenance import Guess, Provenance
from casa_assets.model.issue import Issue
from casa_assets.model.record import Id, Record


class SourceKind(StrEnum):
    """Kind of place that a mesh was found in."""

    FOLDER = "folder"
    OBJAVERSE = "objaverse"
    OBJAVERSE_XL = "objaverse_xl"
    TEXT_TO_3D = "text_to_3d"
    MANIFEST = "manifest"


class Source(Record):
    """One input, as its source describes it; nothing here was guessed.

    Attributes:
        kind: what kind of source it stands in.
        path: main file, POSIX, relative to the folder that the user named (its base name for a single file).
        uid, title, author, licence, uri: as stated; licence is an SPDX id where the source's word maps to one.
        prompt, generator: for generated meshes.
        category: the source's own word for what it is, not yet looked up; empty where it says nothing.
        hints: further words that may name the category, best first (file stem, folder names, tags, title).
    """

    kind: SourceKind
    path: str
    uid: str = ""
    title: str = ""
    author: str = ""
    licence: str = "unknown"
    uri: str = ""
    prompt: str = ""
    generator: str = ""
    category: str = ""
    hints: tuple[str, ...] = ()

    def provenance(self, sha256: str, guesses: tuple[Guess, ...]) -> Provenance:
        """Provenance of an asset made of this input: the source's own words, a digest of its bytes, and guesses."""
        return Provenance(
            source=self.kind.value,
            path=self.path,
            sha256=sha256,
            uid=self.uid,
            title=self.title,
            author=self.author,
            licence=self.licence,
            uri=self.uri,
            prompt=self.prompt,
            generator=self.generator,
            guesses=guesses,
        )


class Up(StrEnum):
    """Axis of the file that points up."""

    X = "x"
    Y = "y"
    Z = "z"


class RawPart(Record):
    """One mesh with one material. Vertices are in file units and file axes, node transforms already baked."""

    name: str
    mesh: Mesh
    material: Material


class RawModel(Record):
    """Everything read from one bundle.

    Attributes:
        parts: at least one, in file order.
        metres_per_unit: as the format or file declares it (glTF: 1), None where it does not.
        up: as the format or file declares it (glTF: y), None where it does not.
        format: id of the format, such as `glb`.
        notes: what was odd, repaired or ignored while reading, as warnings.
    """

    parts: Annotated[tuple[RawPart, ...], Field(min_length=1)]
    metres_per_unit: Annotated[float, Field(gt=0)] | None = None
    up: Up | None = None
    format: Id
    notes: tuple[Issue, ...] = ()


class Bundle(Record):
    """The bytes of one input: its main file and every file it refers to; or what was handed over in memory.

    Attributes:
        main: name of the main file.
        files: name as referred to -> content, `main` among them; none where `model` is given.
        notes: references that were missing or refused, as warnings.
        model: what a reader would make of the files, where a caller has it in memory already.
    """

    main: str
    files: dict[str, bytes]
    notes: tuple[Issue, ...] = ()
    model: RawModel | None = None

    @cached_property
    def sha256(self) -> str:
        """Digest of names (but the main one) and contents, sorted by name: moving a package changes nothing."""
        if self.model is not None:
            return self.model.digest
        whole = hashlib.sha256()
        for name, data in sorted(self.files.items(), key=lambda item: (item[0] != self.main, item[0])):
            label = "" if name == self.main else name
            whole.update(label.encode("utf-8", "surrogateescape") + b"\0" + hashlib.sha256(data).digest())
        return whole.hexdigest()
