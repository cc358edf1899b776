"""A short fuzz run of the same kind as `./dev bench fuzz_ingest`, and the readers under hypothesis, which shrinks."""

from __future__ import annotations

import json
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
from tests.support.fuzz import fuzz_run
from tests.support.fuzz.fuzz_corpus import specimens
from tests.support.fuzz.fuzz_mutations import mutate
from tests.support.fuzz.fuzz_run import Plan, Result, case, fuzz
from tests.support.library.libraries import ROOT
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
    assert result.peak_bytes < 1_000_000_000


def test_a_finding_is_kept_with_its_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An error in a reader, of our making, does not go unnoticed."""
    hook = tmp_path / "run" / "work"
    hook.mkdir(parents=True)
    (hook / "sitecustomize.py").write_text(_BROKEN, encoding="ascii")
    monkeypatch.setenv("PYTHONPATH", f"{hook}:{ROOT}")
    monkeypatch.setattr(fuzz_run, "BATCH", 20)
    plan = Plan(seed=3, seconds=0.1, folder=tmp_path / "run", only="stl")
    (result,) = fuzz(plan)
    assert {one.kind for one in result.findings} == {"error"}
    one = result.findings[0]
    folder = tmp_path / "run" / "findings" / f"error_3_{one.number}"
    kept = json.loads((folder / "finding.json").read_text(encoding="utf-8"))
    assert (kept["seed"], kept["number"]) == (3, one.number)
    assert "broken on purpose" in kept["message"]
    assert all((folder / name).read_bytes() == data for name, data in case(plan, one.number)[1].items())


_BROKEN = """
from casa_assets.formats.read import stl


def fail(*_):
    raise ZeroDivisionError("broken on purpose")


stl._text = fail
"""
