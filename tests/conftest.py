"""What all tests share: settings of hypothesis, and one cache of built things for all processes of a run.

No example of hypothesis is judged by the clock, and every run tries the same ones.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.support.library.libraries import made_once, make_boxes, make_few
from tests.support.program.warm_servers import warm_servers

# Rows of a test of content that run near a change; of more, the representatives.
NEAR_ROWS = 20

settings.register_profile("same_examples", deadline=None, derandomize=True)
settings.load_profile("same_examples")


@pytest.fixture(scope="session")
def common(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that all processes of this run of the tests have in common."""
    own = tmp_path_factory.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


@pytest.fixture(scope="session", autouse=True)
def cache(common: Path) -> Iterator[Path]:
    """A cache of the tests' own, so that they neither use nor fill the user's; what one process built, all have.

    CASA_TESTS_CACHE names one that several runs share: CI makes each texture and each part of a kitchen once.
    """
    folder = Path(os.environ.get("CASA_TESTS_CACHE") or common / "cache")
    folder.mkdir(parents=True, exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CASA_ASSETS_CACHE", str(folder))
        yield folder


@pytest.fixture(scope="session", autouse=True)
def servers(cache: Path) -> Iterator[None]:
    """Servers of workers of this process are forked from one that has loaded the libraries."""
    with warm_servers():
        yield


@pytest.fixture(scope="session")
def boxes(common: Path, cache: Path) -> Path:
    """A folder with cheap inputs in `in`, the library of them in `library`, and the lines of its run; only to read."""
    return made_once(common, "boxes", make_boxes)


@pytest.fixture(scope="session")
def few(common: Path, servers: None) -> Path:
    """A folder with two boxes and a broken file in `in`, and the library of them in `library`; only to read."""
    return made_once(common, "few", make_few)


@pytest.hookimpl(tryfirst=True)  # before -m is looked at
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave to `./dev certify` the rows of a test beyond its `representatives(count)`, and content that is unchanged.

    Rows are counted in their order: the ones that tell most for their time come first. Where CASA_TESTS_NEAR is set, as
    by `./dev test --changed`, a change of most content is tried on its representatives.
    """
    seen: Counter[str] = Counter()
    for item in items:
        mark = item.get_closest_marker("representatives")
        if mark is not None:
            test = item.nodeid.partition("[")[0]
            seen[test] += 1
            if seen[test] > mark.args[0]:
                item.add_marker(pytest.mark.certify)
    if any(item.get_closest_marker("content") for item in items):
        from tests.content_keys import unchanged  # what it imports is loaded by the tests of content alone

        for item in unchanged(items, most=NEAR_ROWS if os.environ.get("CASA_TESTS_NEAR") else None):
            item.add_marker(pytest.mark.certify)
