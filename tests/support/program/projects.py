"""Projects of tests: what is laid over the package for one test, and not after it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from casa_assets.projects import VARIABLE, use_project
from tests.support.library.libraries import write_files

Project = Callable[[Mapping[str, str]], Path]


@contextmanager
def project_in(folder: Path) -> Iterator[Project]:
    """Write files into a project, by their names, and use it; with a casa.yaml if none is among them."""

    def written(files: Mapping[str, str]) -> Path:
        use_project(write_files(folder, {"casa.yaml": "name: ours\n", **files}))
        return folder

    yield written
    use_project(None)
    del os.environ[VARIABLE]
