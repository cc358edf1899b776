"""Read what was learned from labelled cases (registry/learned/), and the calibration of confidences."""

from __future__ import annotations

import json
from functools import cache, lru_cache

from casa_assets.core.forest import Forest, forest_from_dict
from casa_assets.errors import RegistryError
from casa_assets.model.registry.rows import ConfidenceModel
from casa_assets.projects import data_root
from casa_assets.registry.load import LEARNED
from casa_assets.registry.read import read_document, read_record

# Learned --------------------------------------------------------------------------------------------------------------
# Read what scripts in benchmarks/ have learned: the files of registry/learned/.


@lru_cache(maxsize=8)
def learned_forest(name: str) -> Forest:
    """Return the forest of `registry/learned/<name>.json`. Raises RegistryError where it is missing or unsound."""
    path = data_root() / LEARNED / f"{name}.json"
    try:
        return forest_from_dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise RegistryError(f"{LEARNED}/{path.name}", 1, "", "a forest", str(error)) from None


# Confidence -----------------------------------------------------------------------------------------------------------
# Read registry/confidence.yaml, the calibration of `articulate` that benchmarks/articulate/confidence.py fits.


@cache
def load_confidence() -> ConfidenceModel:
    """Return the curves, weights and bars. Raises RegistryError where the file is wrong."""
    document = read_document(data_root() / "confidence.yaml")
    return read_record(ConfidenceModel, document.value, document, ())
