"""Inputs of ingest: the description that the source gives of a mesh, its bytes, and the parts read from them."""

from __future__ import annotations

import hashlib
from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from casa_assets.model.asset.material import Material
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.asset.provenance import Guess, Provenance, place_of
from casa_assets.model.issue import Issue
from casa_assets.model.record import Id, Record, without_blanks


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
        node: of a file that was taken apart: the name of the thing in it; empty for a whole file.
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
    node: str = ""

    @model_serializer(mode="wrap")
    def _without_blanks(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without_blanks(handler(self), ("node",))

    @property
    def place(self) -> str:
        """The path, and behind `#` the name of the thing in the file where it was taken apart."""
        return place_of(self.path, self.node)

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
            node=self.node,
            guesses=guesses,
        )


class Up(StrEnum):
    """Axis of the file that points up."""

    X = "x"
    Y = "y"
    Z = "z"


class RawPart(Record):
    """One mesh with one material. Vertices are in file units and file axes, node transforms already baked.

    Attributes:
        name: an id, each once. nodes: names of the nodes from the root down to the one that carries it, as far as the
            file has any; parts of one node have the same.
        copy_number: from 1,, of the copy that a list of places makes of the mesh; 0 where there is no such list.
    """

    name: str
    mesh: Mesh
    material: Material
    nodes: tuple[str, ...] = ()
    copy_number: int = 0

    @model_serializer(mode="wrap")
    def _without_blanks(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without_blanks(handler(self), ("nodes", "copy_number"))


class RawModel(Record):
    """Everything read from one bundle.

    Attributes:
        parts: at least one, in file order.
        metres_per_unit: as the format or file declares it (glTF: 1), None where it does not.
        up: as the format or file declares it (glTF: y), None where it does not.
        format: id of the format, such as `glb`.
        notes: what was odd, repaired or ignored while reading, as warnings.
        joints: bones of the largest rig that moves a mesh; 0 where nothing is rigged.
        instances: copies of meshes that a list of places makes (EXT_mesh_gpu_instancing), all read.
    """

    parts: Annotated[tuple[RawPart, ...], Field(min_length=1)]
    metres_per_unit: Annotated[float, Field(gt=0)] | None = None
    up: Up | None = None
    format: Id
    notes: tuple[Issue, ...] = ()
    joints: int = 0
    instances: int = 0

    @model_serializer(mode="wrap")
    def _without_blanks(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without_blanks(handler(self), ("joints", "instances"))


class Bundle(Record):
    """The bytes of one input: its main file and every file it refers to; or what was handed over in memory.

    Attributes:
        main: name of the main file.
        files: name as referred to -> content, `main` among them; none where `model` is given.
        notes: references that were missing or refused, as warnings.
        model: what a reader would make of the files, where a caller has it in memory already.
        thing: name of the one thing of the file that is meant; empty for the whole file.
    """

    main: str
    files: dict[str, bytes]
    notes: tuple[Issue, ...] = ()
    model: RawModel | None = None
    thing: str = ""

    @cached_property
    def sha256(self) -> str:
        """Digest of names (but the main one) and contents, sorted by name: moving a package changes nothing.

        Of a thing in a file, a digest of the file's and of the thing's name.
        """
        whole = self.whole_sha256
        return hashlib.sha256(f"{whole}\0{self.thing}".encode()).hexdigest() if self.thing else whole

    @cached_property
    def whole_sha256(self) -> str:
        """Digest of all files, whichever thing of them is meant."""
        if self.model is not None:
            return self.model.digest
        whole = hashlib.sha256()
        for name, data in sorted(self.files.items(), key=lambda item: (item[0] != self.main, item[0])):
            label = "" if name == self.main else name
            whole.update(label.encode("utf-8", "surrogateescape") + b"\0" + hashlib.sha256(data).digest())
        return whole.hexdigest()
