"""A short fuzz run of the same kind as `./dev bench fuzz_ingest`, and the readers under hypothesis, which shrinks."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.model.source import Bundle
from tests.support.fuzz.fuzz_corpus import specimens
from tests.support.fuzz.fuzz_mutations import mutate
from tests.support.fuzz.fuzz_run import Plan, Result, fuzz
from tests.support.mesh.mesh_files import LIMITS

STOCK = specimens()


@pytest.mark.parametrize("name", sorted(STOCK))
@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(rng=st.randoms(use_true_random=False))
def test_a_mutant_is_read_or_rejected(name: str, rng: Random) -> None:
    files = dict(STOCK[name])
    victim = next(iter(files))
    files[victim] = mutate(files[victim], victim.rpartition(".")[2], rng)
    with suppress(Rejected):
        model = load(Bundle(main=victim, files=files), LIMITS)
        assert all(np.isfinite(part.mesh.vertices).all() for part in model.parts)


@pytest.mark.slow
def test_two_seconds_of_fuzzing_find_nothing(tmp_path: Path) -> None:
    result = Result()
    for result in fuzz(Plan(seed=20, seconds=2, folder=tmp_path, wholes=1)):
        assert result.findings == []
    assert result.cases >= 100
    assert result.verdicts["sound"] > 0
    assert result.peak_bytes < 700_000_000
