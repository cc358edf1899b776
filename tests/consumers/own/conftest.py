"""What the tests of users' own things share: an environment with the wheel in it, far from the checkout."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.installed import Environment, install


@pytest.fixture(scope="session")
def user(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """An environment with the wheel of this checkout."""
    return install(tmp_path_factory.mktemp("user") / "environment", wheel)
