"""Plans as language models write them: files, and variants that differ little from one.

`variants.yaml` has these: name of a plan -> name of its variant -> texts, each of which is there once, with what is
written in their place, one after the other.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from casa_assets.registry.read import read_document

FOLDER = Path(__file__).parents[2] / "unit" / "layouts" / "check_plan"


@cache
def plans() -> dict[str, str]:
    files = {path.stem: path.read_text(encoding="utf-8") for path in (FOLDER / "corpus").glob("*.yaml")}
    made = {}
    for name, variants in read_document(FOLDER / "variants.yaml").value.items():
        for variant, edits in variants.items():
            text = files[name] if name in files else (FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
            for old, new in edits:
                assert text.count(old) == 1, (variant, old)
                text = text.replace(old, new)
            made[variant] = text
    return dict(sorted({**files, **made}.items()))
