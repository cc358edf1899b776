"""Shared parts of all pages: templates with every value escaped, meanings of codes, files that show models in 3D."""

from __future__ import annotations

import base64
import gzip
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from casa_assets import registry
from casa_assets.cache.cache_key import key_of
from casa_assets.cache.store import recall, remember
from casa_assets.core.system import process_name
from casa_assets.errors import BatchFault
from casa_assets.formats.gltf import asset_glb
from casa_assets.library.entry_files import CERTIFICATE, read_asset
from casa_assets.library.library import Library
from casa_assets.model.registry.rows import Rejection
from casa_assets.runs.engine import run_batch
from casa_assets.runs.limits import WorkerFailure

if TYPE_CHECKING:
    from casa_assets.library.entry import Entry

FOLDER = "templates"
# Rows that a page lists. A browser loads and searches this many at once, and the page stays below ten megabytes; what
# follows is in the JSON file beside it.
MAX_ROWS = 5_000
# Advice where a reason has none.
DEFAULT_ADVICE = "Look at the picture and the numbers, and fix the mesh."
SUFFIX = ".glb.js"  # of the script file of a model
MADE_BY = "made_by.txt"
WORKER_BYTES = 1_000_000_000  # of memory, that reading an asset and writing its model may take
# A page with models may load scripts beside it, and the pictures inside a model, which the viewer hands itself.
MODEL_POLICY = Markup("script-src 'unsafe-inline' 'self' file:; connect-src blob:; worker-src blob:")


def render_template(name: str, **values: Any) -> str:
    """The text of a template of the folder `templates/`, filled in with escaped values; `Markup` stays as it is.

    The name has to be a string literal in the caller's code, which makes the template, and the files that it includes,
    a part of the caller's cache key.
    """
    return _environment().get_template(name).render(version=version("casa-assets"), **values)


def relative_link(path: str) -> str:
    """The URL of a path relative to the page; `./` in front keeps a colon from being read as a scheme."""
    return "./" + quote(path.lstrip("/"))


def explanations() -> dict[str, str]:
    """Code -> title and description of every check, such as `Overall size: The longest side ...`."""
    known = recall("explanations")
    if isinstance(known, dict):
        return known
    from casa_assets.checks.table import explained  # here, since it loads all checks

    found = explained(registry.load().limits)
    remember(found, "explanations")
    return found


@dataclass(frozen=True)
class Words:
    """Meanings of codes: reasons of the stages, and code of a check -> its title and what is tested."""

    rejections: Mapping[str, Rejection]
    explanations: Mapping[str, str]

    def meaning(self, code: str) -> str:
        """Return the meaning of a code; empty for an unknown code."""
        rejection = self.rejections.get(code)
        return rejection.meaning if rejection else self.explanations.get(code, "")

    def needs_nothing(self, code: str) -> bool:
        """True if a code only describes what was done to an input and its remedy requires no action."""
        rejection = self.rejections.get(code)
        return rejection is not None and rejection.remedy.startswith("Nothing")

    def reason_and_fix(self, entry: Entry) -> tuple[str, str]:
        """Return what was wrong with a rejected input, and what to do about it."""
        rejection = self.rejections.get(entry.code)
        if rejection:
            return entry.message, rejection.remedy
        # The message of a check ends with what to do.
        fault, _, fix = entry.message.partition("; ")
        return (f"{fault}.", f"{fix[:1].upper()}{fix[1:]}.") if fix else (entry.message, DEFAULT_ADVICE)


def all_words() -> Words:
    """Return the meanings of all codes."""
    return Words(registry.load().rejections, explanations())


@lru_cache(maxsize=1)
def _environment() -> Environment:
    made = Environment(
        loader=FunctionLoader(_source),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.policies["json.dumps_kwargs"] = {"sort_keys": True, "separators": (",", ":"), "allow_nan": False}
    made.globals["source"] = _unescaped_source
    made.globals["model_policy"] = MODEL_POLICY
    made.filters["relative_link"] = relative_link
    return made


def _source(name: str) -> str:
    return files("casa_assets.show.page").joinpath(FOLDER, name).read_text(encoding="utf-8")


def _unescaped_source(name: str) -> Markup:
    """Return a style sheet or script of this package, unescaped."""
    return Markup(_source(name))  # noqa: S704  a file of this package


@lru_cache(maxsize=1)
def viewer_script() -> bytes:
    """The bundle: three.js and our source, one classic script that defines `casaViewer`."""
    return files("casa_assets.show.page").joinpath("bundle", "viewer.js").read_bytes()


@lru_cache(maxsize=1)
def viewer_name() -> str:
    """File name of the viewer; it holds its digest, so that pages of two versions may lie side by side."""
    return f"viewer_{hashlib.sha256(viewer_script()).hexdigest()[:12]}.js"


def put_viewer(folder: Path) -> str:
    """Write the viewer into a folder where it is missing; returns its file name."""
    target = folder / viewer_name()
    if not target.is_file() or target.stat().st_size != len(viewer_script()):
        folder.mkdir(parents=True, exist_ok=True)
        target.write_bytes(viewer_script())
    return target.name


@dataclass(frozen=True)
class ModelFiles:
    """Name of a model, and paths of its script file and of the viewer, relative to the page that shows it."""

    name: str
    script: str
    viewer: str


def model_script(name: str, glb: bytes) -> bytes:
    """Content of the script file of a model, named by letters, digits, `_`, `-`; the same GLB is the same bytes."""
    packed = base64.b64encode(gzip.compress(glb, 9, mtime=0)).decode("ascii")
    return f'casaModel("{name}","{packed}");\n'.encode("ascii")


def put_model(folder: Path, name: str, glb: bytes) -> str:
    """Write `<name>.glb.js` into a folder, put in place by one rename; returns its file name."""
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"{name}{SUFFIX}"
    fresh = folder / f".{target.name}.{process_name()}"
    fresh.write_bytes(model_script(name, glb))
    fresh.replace(target)
    return target.name


@dataclass(frozen=True)
class PageModels:
    """Where a page finds the models of its assets, relative to it: `<folder>/<id>.glb.js`, and the viewer."""

    folder: str
    viewer: str

    def of(self, asset_id: str) -> ModelFiles:
        """Return the files with which the page shows the model of an asset."""
        return ModelFiles(asset_id, f"{self.folder}/{asset_id}{SUFFIX}", self.viewer)

    @property
    def data(self) -> dict[str, str]:
        """As the script of the page reads it."""
        return {"folder": self.folder, "suffix": SUFFIX, "viewer": self.viewer}


def models_of(target: Path) -> PageModels:
    """Where the page `target` finds its models."""
    folder = f"./{quote(folder_of(target).name)}"
    return PageModels(folder, f"{folder}/{viewer_name()}")


def folder_of(target: Path) -> Path:
    """Return the folder of the models of a page, such as `report_models` next to `report.html`."""
    return target.with_name(f"{target.stem}_models")


def write_models(root: Path, target: Path, jobs: int = 0) -> Iterator[tuple[int, int]]:
    """Write the models of the assets of a library that are missing; yields (how many there are, of how many).

    A model is made again where its asset was written after it, by a correction for instance, and all are where the
    code that makes them has changed. Those of assets that are gone are removed. Raises BatchFault.
    """
    folder = folder_of(target)
    _empty_unless_made_by(key_of(asset_glb, put_viewer), folder)
    put_viewer(folder)
    folders = {path.name: path for path in Library(root).accepted()}
    for old in folder.glob(f"*{SUFFIX}"):
        if old.name.removesuffix(SUFFIX) not in folders:
            old.unlink()
    missing = []
    for name, path in folders.items():
        model = folder / f"{name}{SUFFIX}"
        if not model.is_file() or model.stat().st_mtime_ns <= (path / CERTIFICATE).stat().st_mtime_ns:
            missing.append(path)
    done = len(folders) - len(missing)
    yield done, len(folders)
    faults: dict[str, str] = {}
    work = partial(_write_model, folder=folder)
    for number, answer in run_batch(work, missing, folder, jobs, warm, WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[missing[number].name] = answer.text
        done += 1
        yield done, len(folders)
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def _empty_unless_made_by(key: str, folder: Path) -> None:
    """Remove models and viewers that other code has made; the folder keeps the key of the code that fills it."""
    mark = folder / MADE_BY
    if mark.is_file() and mark.read_text(encoding="utf-8") == key:
        return
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.js"):
        old.unlink()
    mark.write_text(key, encoding="utf-8")


def _write_model(path: Path, folder: Path) -> str:
    asset = read_asset(path)
    return put_model(folder, asset.id, asset_glb(asset, with_layers=True))


def warm() -> None:
    """Nothing: all that a worker needs is loaded with this module."""
