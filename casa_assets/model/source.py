"""Inputs of ingest: what the source says of a mesh, its bytes, the parts read from them, and what a person decided."""

from __future__ import annotations

import hashlib
from enum import StrEnum
from functools import cached_property
from typing import Annotated

from pydantic import Field

from casa_assets.model.asset.asset import Guess, Provenance, place_of
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Issue
from casa_assets.model.record import BriefRecord, Id, Record


class SourceKind(StrEnum):
    """Kind of source that a mesh was found in."""

    FOLDER = "folder"
    OBJAVERSE = "objaverse"
    OBJAVERSE_XL = "objaverse_xl"
    TEXT_TO_3D = "text_to_3d"
    MANIFEST = "manifest"


class Source(BriefRecord):
    """One input, as its source describes it; nothing here was guessed.

    Attributes:
        path: main file, POSIX, relative to the folder that the user named (its base name for a single file).
        uid, title, author, licence, uri: as stated; licence is an SPDX id if the source's word maps to one.
        prompt, generator: for generated meshes.
        category: the source's own word for the object, not yet looked up; empty if it states no category.
        hints: further words that may name the category, best first (file stem, folder names, tags, title).
        node: name of the object within the file, for a file that was split; empty for a whole file.
    """

    BLANKS = ("node",)

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

    @property
    def place(self) -> str:
        """The path, followed by `#` and the name of the object if the file was split."""
        return place_of(self.path, self.node)

    def provenance(self, sha256: str, guesses: tuple[Guess, ...]) -> Provenance:
        """Provenance of an asset made of this input: the source's own words, a digest of its bytes, and guesses."""
        shared = type(self).model_fields.keys() & Provenance.model_fields.keys()
        words = {name: getattr(self, name) for name in shared}
        return Provenance(source=self.kind.value, sha256=sha256, guesses=guesses, **words)


class Up(StrEnum):
    """Axis of the file that points up."""

    X = "x"
    Y = "y"
    Z = "z"


class RawPart(BriefRecord):
    """One mesh with one material. Vertices are in file units and file axes, with node transforms applied.

    Attributes:
        nodes: names of the nodes from the root down to the one that carries it, as far as the file names them; parts of
            one node have the same names.
        copy_number: number, from 1, of this copy of the mesh in a list of instances; 0 if the file has no such list.
    """

    BLANKS = ("nodes", "copy_number")

    name: str
    mesh: Mesh
    material: Material
    nodes: tuple[str, ...] = ()
    copy_number: int = 0


class RawModel(BriefRecord):
    """Everything read from one bundle.

    Attributes:
        parts: in file order. format: its id, such as `glb`.
        metres_per_unit, up: as declared by the format or file (glTF: 1 and y), or None if not declared.
        notes: warnings about unusual, repaired or ignored content.
        joints: number of bones of the largest rig that moves a mesh; 0 if the file has no rig.
        instances: number of copies of meshes from lists of instances (EXT_mesh_gpu_instancing), all of which were read.
    """

    BLANKS = ("joints", "instances")

    parts: Annotated[tuple[RawPart, ...], Field(min_length=1)]
    metres_per_unit: Annotated[float, Field(gt=0)] | None = None
    up: Up | None = None
    format: Id
    notes: tuple[Issue, ...] = ()
    joints: int = 0
    instances: int = 0


class Bundle(Record):
    """The bytes of one input: its main file and every file it refers to; or a model that was passed in memory.

    Attributes:
        files: name as referred to -> content, including the main file; empty if `model` is given.
        notes: warnings about references that were missing or refused.
        model: the result that a reader would make of the files, if a caller already has it in memory.
        thing: name of one object of the file, if only that object is meant; empty for the whole file.
    """

    main: str
    files: dict[str, bytes]
    notes: tuple[Issue, ...] = ()
    model: RawModel | None = None
    thing: str = ""

    @cached_property
    def sha256(self) -> str:
        """Digest of names (except the main one) and contents, sorted by name: moving a package changes nothing.

        For one object of a file: a digest of the file's digest and the object's name.
        """
        files = hashlib.sha256()
        for name, data in sorted(self.files.items(), key=lambda item: (item[0] != self.main, item[0])):
            label = "" if name == self.main else name
            files.update(label.encode("utf-8", "surrogateescape") + b"\0" + hashlib.sha256(data).digest())
        whole = files.hexdigest() if self.model is None else self.model.digest
        return hashlib.sha256(f"{whole}\0{self.thing}".encode()).hexdigest() if self.thing else whole


class UpAxis(StrEnum):
    """Axis of the file that points up."""

    X = "x"
    Y = "y"
    Z = "z"
    MINUS_X = "minus_x"
    MINUS_Y = "minus_y"
    MINUS_Z = "minus_z"


class Word(StrEnum):
    """A person's decision about an asset in review, in its current form."""

    ACCEPT = "accept"
    REJECT = "reject"


class UserOverride(Record):
    """Values that a person sets for one input; empty fields are guessed.

    Attributes:
        turn_deg: turn about z, counter-clockwise from above, instead of the search for the front.
        size_m: longest side; 0: guessed. mass_kg: 0: guessed.
    """

    category: str = ""
    up: UpAxis | None = None
    turn_deg: float | None = None
    decision: Word | None = None
    size_m: Annotated[float, Field(ge=0, le=100)] = 0.0
    mass_kg: Annotated[float, Field(ge=0, le=10000)] = 0.0

    @property
    def is_empty(self) -> bool:
        """True if every field is empty."""
        return self == NO_OVERRIDE


NO_OVERRIDE = UserOverride()
