"""Which tests of other programs `./dev consumers` runs: those whose subject has changed since they last passed.

Most of these tests need a large environment of their own and fail where one part of the package has changed. Such a
file states its environments and the paths that it watches in `WATCHED`, a page of docs is watched by itself. Its key is
a digest of all that stands there, of its own text, and of the files of tests/ that it imports or names. What is not
named here runs each time: kitchens and objects in RoboCasa, SimReady's validator, the installed wheel, the pages in
`PAGES`.

Files whose key is the one in watched.json are left to `./dev certify`, which runs all of them. Both record the keys
where everything has passed.

`python -m tests.consumers.watched` prints the environments that are needed; `--all` those of all, `--write` records.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from casa_assets.cache.cache_key import SHOWN, digest_of
from tests.content_keys import python_text

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RECORDED = HERE / "watched.json"
ENVIRONMENTS = HERE / "environments"
# Needed by what runs each time.
ALWAYS = ("robocasa", "robosuite")
DOCUMENTS = "test_documents.py"
# Pages that are run each time: what a reader tries first.
PAGES = ("README.md", "docs/howto/meshes/mesh.md")


@dataclass(frozen=True)
class Watched:
    """What a file of tests hangs on.

    Attributes:
        environments: names of lists in environments/. paths: files and folders, relative to the checkout.
    """

    environments: tuple[str, ...]
    paths: tuple[str, ...]


def _package(*names: str) -> tuple[str, ...]:
    return tuple(f"casa_assets/{name}" for name in names)


_PAGES_IN_A_BROWSER = Watched(
    ("browser",), _package("show/reports", "show/view", "show/page", "articulate/run/review_page.py")
)
_MJCF = _package("formats/mjcf", "formats/values.py", "model/asset", "model/kitchen")
_BATCHES = Watched(
    ("engines",), (*_package("addons/batch", "checks/scene/light_forms.py", "checks/scene/engine_sizes.py"), *_MJCF)
)
_CLUSTER = Watched(("ray",), _package("runs", "ingest/run"))
_STORES = Watched(("stores",), _package("library", "runs/remote.py", "ingest/sources"))

_OWN = Watched((), _package("cli/verbs/project.py", "cli/starter", "projects.py", "registry"))
_ROBOCASA = Watched(("robocasa",), _package("checks/design", "model/registry/contract.py", "addons/robocasa"))

# By path relative to this folder.
WATCHED = {
    "cluster/test_faults.py": _CLUSTER,
    "own/test_plugins.py": _OWN,
    "own/test_projects.py": _OWN,
    "own/test_rows.py": _OWN,
    "robocasa/test_fixtures.py": _ROBOCASA,
    "robocasa/test_start_states.py": _ROBOCASA,
    "test_batches.py": _BATCHES,
    "test_blender.py": Watched(
        ("blender",),
        _package("core/system.py", "formats/read/blend.py", "formats/read/blend_convert.py", "show/stills/blender")
        + _package("show/stills/photoreal.py"),
    ),
    "test_clip.py": Watched(("clip",), _package("library/clip.py", "library/library_report.py", "articulate/kinds.py")),
    "test_kitchens.py": Watched(
        ("blender", "mujoco331", "mujoco337", "newton", "robosuite"), (*_MJCF, *_package("formats/usd"))
    ),
    "test_meshopt.py": Watched(("meshopt",), _package("formats/read/gltf.py", "formats/read/gltf_document.py")),
    "test_notebook.py": Watched((), ("docs/quickstart.ipynb", "casa_assets/api", "casa_assets/__init__.py")),
    "test_old_mujoco.py": Watched(("mujoco331", "mujoco337"), _MJCF),
    "test_pages_of_many.py": _PAGES_IN_A_BROWSER,
    "test_review_keys.py": _PAGES_IN_A_BROWSER,
    "test_robocasa_tasks.py": _ROBOCASA,
    "test_robots.py": Watched(
        ("robots",), _package("checks/robots.py", "core/hand_dynamics.py", "addons/robots", "cli/verbs/scenes.py")
    ),
    "test_site.py": Watched(("browser", "docs"), ("docs", "mkdocs.yml")),
    "test_stores.py": _STORES,
    "test_urdf.py": Watched(
        ("urdf",), (*_package("formats/urdf.py", "checks/readers/urdf_facts.py"), "docs/howto/use/urdf.md")
    ),
    "test_viewer.py": _PAGES_IN_A_BROWSER,
}


def key_of(file: str) -> str:
    """First digits of the key of a file of tests, by its path relative to this folder.

    Raises:
        FileNotFoundError: a path or an environment that it states is not there.
    """
    watched = WATCHED.get(file, Watched((), ()))
    lists = [ENVIRONMENTS / f"{name}.txt" for name in watched.environments]
    places = [*lists, *_own(HERE / file), *(ROOT / path for path in watched.paths)]
    return digest_of([_digest(place) for place in places])[:SHOWN]


def page_key(page: str) -> str:
    """First digits of the key of a page of docs."""
    return digest_of(_digest(ROOT / page), key_of(DOCUMENTS))[:SHOWN]


def _own(file: Path) -> list[Path]:
    """A file of tests, the files of tests/ that it imports, and those that any of them names, such as a script."""
    found, waiting = set[Path](), [file]
    while waiting:
        place = waiting.pop()
        if place not in found:
            found.add(place)
            if place.suffix == ".py":
                read = python_text(place.relative_to(ROOT).as_posix())
                named = (folder / text for folder in (place.parent, HERE) for text in read.texts if "." in text)
                waiting += [*(ROOT / helper for helper in read.helpers), *(path for path in named if _is_file(path))]
    return sorted(found)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a text that is no name of a file, such as one that is too long
        return False


@cache
def _digest(place: Path) -> str:
    """Of a file, or of all files in a folder with their names; what Python has compiled is left out.

    Raises:
        FileNotFoundError: there is neither.
    """
    if place.is_file():
        return hashlib.sha256(place.read_bytes()).hexdigest()
    if not place.is_dir():
        raise FileNotFoundError(f"{place} is not there; tests/consumers/watched.py names it")
    files = (path for path in sorted(place.rglob("*")) if path.is_file() and "__pycache__" not in path.parts)
    return digest_of([(path.relative_to(place).as_posix(), _digest(path)) for path in files])


def present_keys() -> dict[str, str]:
    """Keys of all files and pages that may be left out, by their paths; those of pages relative to the checkout."""
    from tests.consumers.test_documents import RUN  # reads all pages

    return {file: key_of(file) for file in WATCHED} | {page: page_key(page) for page in RUN if page not in PAGES}


def read_recorded() -> dict[str, str]:
    """The recorded keys; empty if there are none."""
    found: dict[str, str] = json.loads(RECORDED.read_text(encoding="utf-8")) if RECORDED.is_file() else {}
    return found


def changed(recorded: Mapping[str, str] | None = None) -> frozenset[str]:
    """Files and pages whose keys are not those that were recorded (None reads watched.json)."""
    known = recorded if recorded is not None else read_recorded()
    return frozenset(name for name, key in present_keys().items() if known.get(name) != key)


def environments(names: Iterable[str]) -> list[str]:
    """Names of what some files need, and of what is needed each time."""
    needed = {name for file in names if file in WATCHED for name in WATCHED[file].environments}
    return sorted(needed | set(ALWAYS))


def main() -> None:
    """Print the environments that are needed, or record keys."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.consumers.watched", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument(
        "--all", action="store_true", help="environments of all files, also of those that are unchanged"
    )
    parser.add_argument("--write", action="store_true", help="record the keys; all of these tests have passed")
    arguments = parser.parse_args()
    if arguments.write:
        RECORDED.write_text(json.dumps(present_keys(), indent=1, sort_keys=True) + "\n", encoding="utf-8")
    elif arguments.all:
        print("\n".join(path.stem for path in sorted(ENVIRONMENTS.glob("*.txt"))))
    else:
        print("\n".join(environments(changed())))


if __name__ == "__main__":
    main()
