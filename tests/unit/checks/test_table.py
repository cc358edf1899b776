"""The table of checks as a whole: every code has examples, a limit that decides and a line in the documents."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from string import Formatter
from typing import Any

from casa_assets import registry
from casa_assets.checks.check import Check
from casa_assets.checks.table import TABLE
from casa_assets.show.reports.checks_page import checks_markdown, every_code
from casa_assets.textures.check import SET_CHECKS
from casa_assets.textures.check import TABLE as TEXTURES

ROOT = Path(__file__).parents[3]
KNOWN = registry.load()
PAGE = checks_markdown()
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


def faults_of(check: Check) -> Iterator[str]:
    """What is wrong with a row of the table; how a drop is done may stay out of what it says."""
    named = {name for _, name, _, _ in Formatter().parse(check.description) if name}
    if (check.limit is not None) != bool(named & {"limit", "mm", "mm2"}):
        yield "the number that decides is not said"
    if check.limit is not None and check.limit not in KNOWN.limits:
        yield "its limit is not registered"
    elif check.limit is not None and check.unit != KNOWN.limit_units[check.limit]:
        yield "its limit has another unit"
    elif "{" in check.describe(KNOWN.limits):
        yield "a number of its sentence is not filled in"
    if check.code in KNOWN.rejections:
        yield "its code is that of a rejection"
    if f"| {check.code} | **{check.title}**" not in PAGE:
        yield "it is not in the documents"


def test_every_row_names_its_number_which_is_registered_in_its_unit() -> None:
    assert [(check.code, fault) for check in TABLE for fault in faults_of(check)] == []


def test_document_is_the_printed_one() -> None:
    page = ROOT / "docs" / "reference" / "checks.md"
    assert page.read_text(encoding="utf-8") == PAGE, "run ./dev docs"


def test_every_code_in_the_program_is_explained() -> None:
    explained = every_code()
    unknown = {
        f"{path.relative_to(ROOT).as_posix()}: {code}"
        for path in sorted((ROOT / "casa_assets").rglob("*.py"))
        for code in CODE.findall(path.read_text(encoding="utf-8"))
        if code not in explained
    }
    assert unknown == set()


def test_every_waiver_names_a_check() -> None:
    assert {waiver.code for waiver in KNOWN.waivers} <= {check.code for check in TABLE}


def taken_by_key() -> set[str]:
    """Keys that the sources take out of a mapping of limits: `limits["key"]`, `brief.limits["key"]`."""
    found = set()
    for path in sorted((ROOT / "casa_assets").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
                name = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
                if name.endswith("limits"):
                    found.add(str(node.slice.value))
    return found


def test_every_limit_is_read_and_none_is_asked_for_that_is_not_there() -> None:
    textures = {row.limit for row in TEXTURES} | {key for _, key, _ in SET_CHECKS.values()}
    asked = {key for check in TABLE for key in (check.limit, *check.others) if key}
    assert KNOWN.limits.keys() - asked - textures - taken_by_key() == set()
    assert asked <= KNOWN.limits.keys()
