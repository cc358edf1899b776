"""The table of checks as a whole: every code has examples, a limit, a reason and a line in the documents."""

from __future__ import annotations

import importlib
import re
from itertools import groupby
from pathlib import Path
from string import Formatter
from typing import Any

import pytest

from casa_assets import registry
from casa_assets.checks.check import Check
from casa_assets.checks.table.table import TABLE
from casa_assets.pipeline.reports.checks_page import checks_markdown, codes

ROOT = Path(__file__).parents[3]
KNOWN = registry.load()
CODE = re.compile(r"[\"']([A-Z]{3}[0-9]{3})[\"']")


def examples() -> dict[str, tuple[Any, Any]]:
    """Code -> (good, bad), gathered from every module of tests that has a dict EXAMPLES."""
    found: dict[str, tuple[Any, Any]] = {}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        if re.search(r"^EXAMPLES(: dict.*)? = \{", path.read_text(encoding="utf-8"), re.MULTILINE):
            module = importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
            assert not found.keys() & module.EXAMPLES.keys(), f"{path.name} has examples of a code that has some"
            found |= module.EXAMPLES
    return found


def test_every_code_has_a_good_and_a_bad_example() -> None:
    found = examples()
    assert found.keys() == {check.code for check in TABLE}
    assert [code for code, (good, bad) in found.items() if not callable(good) or not bad] == []


def test_codes_are_unique_and_in_order_within_their_family() -> None:
    families = [family for family, _ in groupby(TABLE, key=lambda check: check.code[:3])]
    assert len(families) == len(set(families))
    for family in families:
        codes = [check.code for check in TABLE if check.code.startswith(family)]
        assert codes == sorted(set(codes))


@pytest.mark.parametrize("check", TABLE, ids=lambda check: check.code)
class TestRow:
    def test_says_what_is_tested_and_what_to_do(self, check: Check) -> None:
        told = check.describe(KNOWN.limits)
        assert 2 <= len(check.title.split()) <= 6
        assert check.title[0].isupper()
        assert re.fullmatch(r"[A-Za-z`].*; .*\.", told), "what is measured; what to do"
        assert told.count(". ") <= 1, "one sentence"
        assert 12 <= len(told.split()) <= 45
        assert "{" not in told
        assert check.function.__doc__

    def test_names_each_of_its_limits(self, check: Check) -> None:
        """A description that leaves out the number that decides says too little; how a drop is done may stay out."""
        named = {name for _, name, _, _ in Formatter().parse(check.description) if name}
        assert (check.limit is not None) == bool(named & {"limit", "mm", "mm2"})

    def test_limit_is_registered_in_its_unit(self, check: Check) -> None:
        if check.limit is not None:
            assert check.limit in KNOWN.limits
            assert check.unit == KNOWN.limit_units[check.limit]

    def test_is_documented(self, check: Check) -> None:
        assert f"| {check.code} | **{check.title}**" in checks_markdown()

    def test_is_no_rejection(self, check: Check) -> None:
        assert check.code not in KNOWN.rejections


def test_document_is_the_printed_one() -> None:
    page = ROOT / "docs" / "reference" / "checks.md"
    assert page.read_text(encoding="utf-8") == checks_markdown(), "run ./dev docs"


def test_every_code_in_the_program_is_explained() -> None:
    explained = codes()
    unknown = {
        f"{path.relative_to(ROOT).as_posix()}: {code}"
        for path in sorted((ROOT / "casa_assets").rglob("*.py"))
        for code in CODE.findall(path.read_text(encoding="utf-8"))
        if code not in explained
    }
    assert unknown == set()


def test_every_waiver_names_a_check() -> None:
    assert {waiver.code for waiver in KNOWN.waivers} <= {check.code for check in TABLE}
