"""The picture of imports in ARCHITECTURE.md is that of the code."""

from __future__ import annotations

from benchmarks.imports import PAGE, arrows, box_of, embedded, imported, picture


def test_the_page_shows_what_the_script_prints() -> None:
    assert embedded(PAGE.read_text(encoding="utf-8")) == picture(), "python -m benchmarks.imports --write"


def test_every_form_of_import_is_read() -> None:
    text = (
        "import numpy, casa_assets.core.numeric\n"
        "from casa_assets import model, registry\n"
        "def f():\n    from casa_assets.model.asset import Asset\n"
    )
    assert [sorted(names) for names in imported(text) if names] == [
        ["core.numeric"],
        ["model", "registry"],
        ["model.asset.Asset"],
    ]
    assert box_of("ingest.run.inputs") != box_of("ingest.clean") == box_of("articulate.infer")
    assert box_of("errors") is None


def test_arrows_lead_down() -> None:
    found = arrows()
    assert found
    assert all(start < end for start, end in found)
