"""Primitives compressed by Draco -> the accessors that they stand for. Ref: KHR_draco_mesh_compression."""

from __future__ import annotations

import DracoPy
import numpy as np

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf.accessor import Accessors
from casa_assets.ingest.load.gltf.tree import JsonObject

EXTENSION = "KHR_draco_mesh_compression"


def unpack(primitive: JsonObject, accessors: Accessors) -> None:
    """Decode a compressed primitive and hand its arrays to the accessors that it names; others are left as they are.

    Raises:
        Rejected: TRUNCATED where the bytes are no Draco mesh, LENGTH_MISMATCH where it holds other counts than the
            accessors claim, TOO_LARGE, and what buffer views are refused for.
    """
    extension, attributes = primitive.child("extensions").child(EXTENSION), primitive.child("attributes")
    if not extension.value or accessors.is_stored(attributes.count("POSITION")):
        return
    ids = extension.child("attributes")
    if not ids.has("POSITION"):
        raise ids.fail("POSITION", "an attribute of the Draco data")
    wanted = {key: attributes.count(key) for key in ids.value if attributes.has(key)}
    # The claims are checked before anything is decoded; a mesh that holds more is refused by its own counts below.
    for index in (*wanted.values(), *([primitive.count("indices")] if primitive.has("indices") else [])):
        accessors.check_count(index)
    try:
        mesh = DracoPy.decode(accessors.view_bytes(extension.count("bufferView")))
    except (ValueError, TypeError, RuntimeError, DracoPy.FileTypeException) as error:
        message = f"glTF {extension.place}: the Draco data is broken; fetch or export the file again"
        raise Rejected(codes.TRUNCATED, message) from error
    faces = getattr(mesh, "faces", None)
    if faces is None:
        raise Rejected(codes.NO_FACES, f"glTF {extension.place}: Draco points without faces; export a surface")
    if primitive.has("indices"):
        accessors.supply(primitive.count("indices"), np.asarray(faces).reshape(-1, 1))
    data = {one["unique_id"]: one["data"] for one in mesh.attributes}
    for key, index in wanted.items():
        array = data.get(ids.count(key))
        if array is None:
            raise ids.fail(key, "an attribute of the Draco data")
        accessors.supply(index, np.asarray(array).reshape(len(array), -1))
