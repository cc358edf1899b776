"""Read the mesh of an input: the whole file, or the one thing in it that is meant."""

from __future__ import annotations

from collections.abc import Mapping

from casa_assets.formats import read
from casa_assets.formats.read.text import printable
from casa_assets.ingest.things.split import model_of_thing
from casa_assets.model.source import Bundle, RawModel


def load(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """Read a mesh. Raises Rejected if the file cannot be read, or no longer holds the thing.

    Args:
        limits: by their names in registry/limits.yaml.
    """
    model = read.load(bundle, limits)
    return model_of_thing(model, bundle.thing, printable(bundle.main)) if bundle.thing else model
