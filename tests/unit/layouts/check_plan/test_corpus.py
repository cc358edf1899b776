"""Plans as language models write them: each fits, has corrections that make it fit, or is told what it lacks where.

`tests.support.kitchen.plan_corpus` has the plans; `expected.yaml` has the sentences of the corrections of each in their
order, or the line and pointer of the first fault that has no correction, behind an exclamation mark; nothing for those
that fit. What is made of a plan that was corrected is tried of a dozen that differ most; of all before a release.
`CASA_NEW_EXPECTED=1` in the environment has the table written again, to be read before it is committed.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from casa_assets.api.schemas import schema_text
from casa_assets.layouts.check_plan.check import check_plan, edited_text, plan_id
from casa_assets.layouts.check_plan.edit import Edit, EditKind
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.run.resolve import params_of, preset_params
from casa_assets.model.kitchen.plan import Plan
from casa_assets.projects import data_root
from casa_assets.registry.kitchens import laid_over_like, load_style, style_names
from casa_assets.registry.read import parse_document, read_document
from tests.support.kitchen.plan_corpus import plans

pytestmark = pytest.mark.content("code", "layouts.check_plan", keep=0)

PLANS = plans()
# A plan that is right, one like another, faults of YAML, words, units of length, rows, corners, openings and islands.
FEW = ("ok_corner", "draft_like", "open_brace", "prose_and_fence", "feet_and_inches", "misspelt_kind")
FEW += ("no_such_wall", "row_too_long", "no_corner", "wide_door", "windows_overlap", "island_too_large")
EXPECTED = Path(__file__).parent / "expected.yaml"
STYLE = "modern_1"
MAX_CALLS = 5


def sentences(name: str) -> list[str]:
    found = check_plan(PLANS[name], f"{name}.yaml", load_style(STYLE)[0])
    if not found.mended:
        first = next(told for told in found.faults if told.mend is None)
        assert first.expected, name
        return [f"! {first.line} {'.'.join(map(str, first.pointer))}".rstrip()]
    return [t.mend.sentence for t in found.faults if t.mend]


# Those that all corrections together make fit.
EACH = [
    pytest.param(name, marks=[pytest.mark.certify] * (name not in FEW))
    for name, said in sorted(read_document(EXPECTED).value.items())
    if not any(one.startswith("!") for one in said or ())
]


def test_mends_are_those_of_the_table() -> None:
    now = {name: sentences(name) for name in PLANS}
    if os.environ.get("CASA_NEW_EXPECTED"):
        rows = "".join(f"{name}:\n" + "".join(f"  - {json.dumps(s)}\n" for s in said) for name, said in now.items())
        EXPECTED.write_text(rows, encoding="utf-8")
    assert now == {name: said or [] for name, said in read_document(EXPECTED).value.items()}
    assert all((said == []) == name.startswith("ok_") for name, said in now.items())


@pytest.mark.parametrize("name", EACH)
def test_a_program_that_makes_the_mends_gets_a_plan(name: str) -> None:
    """The loop of a program that calls `check-plan --json`: it makes the edits, asks again, and builds in the end."""
    text, style, file = PLANS[name], load_style(STYLE)[0], f"{name}.yaml"
    for _ in range(MAX_CALLS):
        found = check_plan(text, file, style)
        if found.fits:
            break
        for told in found.faults:
            facts = json.loads(json.dumps(told.facts))
            assert facts["mend"], facts
            if facts["file"] == file:
                assert 1 <= facts["line"] <= len(PLANS[name].splitlines())
            for edit in facts["mend"]["edits"]:
                change = Edit(EditKind(edit["op"]), tuple(edit["pointer"]), edit["new"])
                text = edited_text(text, file, change)
    assert found.fits, [told.facts for told in found.faults]
    # The code of the families says the same of it as the short table of their sizes.
    document = parse_document(text, file)
    value = laid_over_like(document, plan_id(file)).value if "like" in document.value else document.value
    assert request_kitchen(Plan.model_validate({**value, "id": plan_id(file)}), style, preset_params()).items
    # And they make all that it asks for, in one style each, between them in all.
    other = style_names()[list(PLANS).index(name) % len(style_names())]
    made = check_plan(PLANS[name], file, load_style(other)[0])
    for item in made.kitchen.items if made.kitchen else ():
        params_of(item.choice)  # else CasaError


@pytest.mark.parametrize("name", ["plan", "style"])
def test_plans_and_styles_of_the_package_keep_to_their_schemas(name: str) -> None:
    validator = Draft202012Validator(json.loads(schema_text(name)))
    paths = sorted((data_root() / f"{name}s").glob("*.yaml"))
    assert len(paths) >= 10
    for path in paths:
        assert [f"{e.json_path}: {e.message}" for e in validator.iter_errors(read_document(path).value)] == [], path
    assert next(validator.iter_errors({"title": "x", "like": "galley", "colour": "red"}), None) is not None
    assert next(validator.iter_errors({"title": "x"}), None) is not None
