"""Read registry/confidence.yaml, the calibration of `articulate` that benchmarks/articulate/confidence.py fits."""

from __future__ import annotations

from functools import cache

from casa_assets.model.registry.confidence import ConfidenceModel
from casa_assets.projects import data_root
from casa_assets.registry.read import read_document, read_record


@cache
def load_confidence() -> ConfidenceModel:
    """Return the curves, weights and bars. Raises RegistryError where the file is wrong."""
    document = read_document(data_root() / "confidence.yaml")
    return read_record(ConfidenceModel, document.value, document, ())
