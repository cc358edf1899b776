"""What several files of these tests share: the library of the sample meshes and the wheel, each made once."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling

from tests.consumers.watched import PAGES, WATCHED, changed
from tests.support.library.libraries import made_once
from tests.support.library.object_stores import Server
from tests.support.program.browser import Browser
from tests.support.program.documents import ROOT, blocks, shell
from tests.support.program.environments import Environment, build_wheel, install

HERE = Path(__file__).parent
# The first command of README.md, whose library all pages after it take for granted.
MAKE = next(line for block in blocks("README.md") for line in block.commands if line.startswith("casa-assets ingest"))


# The pages take longest, and each is alone, so that both processes begin with them. The tasks of RoboCasa use two cores
# by themselves, so that at the end none is idle.
FIRST, LAST = "test_documents.py", "test_robocasa_tasks.py"


class ByFile(LoadScopeScheduling):
    """Every file but the pages is run by one process, so that what its module sets up is made once.

    xdist's own groups, `--dist loadgroup`, are lost in pytest 9.2, which no longer takes names of tests from plug-ins.
    """

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        return nodeid if file.endswith(FIRST) else file


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> ByFile | None:
    return ByFile(config, log) if config.getvalue("dist") == "loadgroup" else None


@pytest.hookimpl(tryfirst=True)  # before -m is looked at
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the pages first, and the file that needs no company last.

    What watches nothing that has changed is left to `./dev certify`, see watched.py.
    """
    items.sort(key=lambda item: (item.path.name == LAST) - (item.path.name == FIRST))
    here = [item for item in items if item.path.is_relative_to(HERE)]  # pytest gives all that it found
    new = changed() if here else frozenset[str]()
    for item in here:
        if not is_run(item, new):
            item.add_marker(pytest.mark.certify)


def is_run(item: pytest.Item, new: frozenset[str]) -> bool:
    """Whether `./dev consumers` runs a test: what it watches is new, or it watches nothing of its own."""
    file = item.path.relative_to(HERE).as_posix()
    if file == FIRST:
        page: str = item.callspec.params["page"]  # type: ignore[attr-defined]  # pytest states no type for it
        return page in PAGES or page in new
    return file not in WATCHED or file in new


@pytest.fixture(scope="session")
def samples(common: Path) -> Path:
    """A folder with the examples, and the library of them in `out/library`; the first process that asks makes it."""
    return made_once(common, "samples", _make_samples)


def _make_samples(folder: Path) -> None:
    shutil.copytree(ROOT / "examples", folder / "examples")
    done = shell(MAKE, folder)
    assert done.returncode == 1, done.stdout + done.stderr  # one sample is broken on purpose


@pytest.fixture(scope="session")
def wheel(common: Path) -> Path:
    (built,) = made_once(common, "wheel", partial(build_wheel, ROOT)).glob("*.whl")
    return built


@pytest.fixture(params=["rclone", "seaweedfs"])
def server(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Server]:
    with Server(str(request.param), tmp_path / "server") as made:
        yield made


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    started = Browser()
    yield started
    started.close()


@pytest.fixture(scope="session")
def user(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    return install(tmp_path_factory.mktemp("user") / "environment", wheel)
