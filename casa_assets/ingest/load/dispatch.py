"""Read a bundle into a RawModel by the reader of its format."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import ALIASES, SUFFIX_OF, Format, sniff, suffix_of
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.raw_parts import check_face_count
from casa_assets.model.ingest.source import Bundle, RawModel

Reader = Callable[[Bundle, Mapping[str, float], Notes], RawModel]


def load(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """Read a bundle. Pure: no disk, no network, no clock.

    Args:
        bundle: main file and what it refers to.
        limits: input_faces, input_texture_px, input_texture_pixels, as registry/limits.yaml has them.
    Returns:
        Parts in file units and file axes; the bundle's notes come first among its notes.
    Raises:
        Rejected: with a code of casa_assets.ingest.rejection_codes.
    """
    name = printable(bundle.main)
    if bundle.model is not None:
        check_face_count(sum(len(p.mesh.faces) for p in bundle.model.parts), limits, name)
        return _meant(bundle, bundle.model.replace(notes=bundle.notes + bundle.model.notes))
    data = bundle.files[bundle.main]
    file_format = sniff(data, name)
    notes = Notes()
    suffix = suffix_of(bundle.main)
    if suffix != SUFFIX_OF[file_format] and ALIASES.get(suffix) is not file_format:
        notes.add(
            codes.TYPE_BY_CONTENT,
            name,
            f"{name}: read as {file_format.value.upper()} by its content, not by its name",
        )
    # hostile numbers overflow and cast badly; what comes of it is found and judged in rough.finish
    with np.errstate(all="ignore"):
        model = _reader_of(file_format)(bundle, limits, notes)
    return _meant(bundle, model.replace(notes=bundle.notes + notes.issues))


def _meant(bundle: Bundle, model: RawModel) -> RawModel:
    """The model, or the one thing in it that is meant."""
    if not bundle.thing:
        return model
    from casa_assets.ingest.things.split import model_of_thing

    return model_of_thing(model, bundle.thing, printable(bundle.main))


def _reader_of(file_format: Format) -> Reader:
    """The reader of a format. They are imported when one is asked for: some need libraries that take long to import."""
    readers = _common_readers()
    if file_format in readers:
        return readers[file_format]
    if file_format is Format.USD:
        from casa_assets.ingest.load.usd.reader import read_usd

        return read_usd
    if file_format is Format.FBX:
        from casa_assets.ingest.load.fbx.reader import read_fbx

        return read_fbx
    from casa_assets.ingest.load.by_trimesh.reader import read_3mf, read_off, read_xaml

    return {Format.OFF: read_off, Format.THREE_MF: read_3mf, Format.XAML: read_xaml}[file_format]


def _common_readers() -> Mapping[Format, Reader]:
    """The readers that need nothing but what a worker has loaded for other stages anyway."""
    from casa_assets.ingest.load.blender.reader import read_blend
    from casa_assets.ingest.load.collada.reader import read_dae
    from casa_assets.ingest.load.gltf.scene import read_gltf
    from casa_assets.ingest.load.max3ds.reader import read_3ds
    from casa_assets.ingest.load.ply.reader import read_ply
    from casa_assets.ingest.load.stl import read_stl
    from casa_assets.ingest.load.vrml.reader import read_vrml
    from casa_assets.ingest.load.wavefront.reader import read_obj

    return {
        Format.GLB: read_gltf,
        Format.GLTF: read_gltf,
        Format.OBJ: read_obj,
        Format.PLY: read_ply,
        Format.STL: read_stl,
        Format.DAE: read_dae,
        Format.VRML: read_vrml,
        Format.X3D: read_vrml,
        Format.MAX_3DS: read_3ds,
        Format.BLEND: read_blend,
    }


def warm() -> None:
    """Import the readers of common formats, once for all workers that are forked later."""
    _common_readers()
