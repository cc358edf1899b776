"""A plug-in of pytest that writes down each failure at once: node and last line of what it says, as lines of JSON.

It stands in a folder of its own, which is put on the path of the tests of any checkout, and imports nothing of ours.
"""

import json
import os
from pathlib import Path

import pytest

FILE = "PLANTED_FAILURES"


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Of a test."""
    if report.failed:
        _write(report.nodeid, report.longreprtext)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    """Of a file that cannot be read."""
    if report.failed:
        _write(report.nodeid, report.longreprtext)


def _write(node: str, text: str) -> None:
    errors = [line.removeprefix("E").strip() for line in text.splitlines() if line.startswith("E ")]
    with Path(os.environ[FILE]).open("a", encoding="utf-8") as file:
        file.write(json.dumps({"test": node, "error": (errors or [""])[0][:200]}) + "\n")
