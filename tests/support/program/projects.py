"""Projects of tests: what is laid over the package for one test, and not after it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from casa_assets.projects import VARIABLE, use_project

Project = Callable[[Mapping[str, str]], Path]


@contextmanager
def project_in(folder: Path) -> Iterator[Project]:
    """Write files into a project, by their names, and use it; with a casa.yaml if none is among them."""

    def written(files: Mapping[str, str]) -> Path:
        for name, text in {"casa.yaml": "name: ours\n", **files}.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        use_project(folder)
        return folder

    yield written
    use_project(None)
    del os.environ[VARIABLE]
