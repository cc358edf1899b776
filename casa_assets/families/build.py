"""Build members of families into a library: sample, build, write, render and check each; what objects have besides."""

from __future__ import annotations

import base64
import io
import json
import math
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from statistics import median
from types import ModuleType
from typing import Any

import numpy as np
from PIL import Image

from casa_assets import registry
from casa_assets.asset.assemble import Family, assemble
from casa_assets.asset.family import Params, Supplies
from casa_assets.cache.cache_key import digest_of, key_of, versions_of
from casa_assets.cache.store import Store
from casa_assets.checks import objects, simready
from casa_assets.checks.check import load_table
from casa_assets.checks.check import run as run_checks
from casa_assets.checks.objects import ObjectMember
from casa_assets.core.numeric import Floats, rng_for
from casa_assets.core.system import cache_for
from casa_assets.errors import UnknownId
from casa_assets.library.entry_files import Identity, MadeBy, Producer, write_certificate
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.library.library_report import write_reports
from casa_assets.mesh.grasps import choose_grasps, grasp_site
from casa_assets.mesh.surface import weld
from casa_assets.model.asset.asset import Asset, Labels, split_of
from casa_assets.model.asset.material import PrintedLine
from casa_assets.model.asset.parts import Grasp
from casa_assets.model.issue import Issue, Report
from casa_assets.model.registry.category import Category
from casa_assets.projects import read_once
from casa_assets.registry.families import family, family_names, object_family, object_names
from casa_assets.registry.plugins import LoadedPlugin
from casa_assets.registry.plugins.families import FORMS, MODELS, plugin_families, plugin_forms
from casa_assets.registry.plugins.load import guarded
from casa_assets.registry.plugins.textures import texture_kinds
from casa_assets.runs import asset_package
from casa_assets.runs.engine import attempt, run_batch
from casa_assets.runs.limits import WorkerFailure
from casa_assets.runs.outcome import writing
from casa_assets.runs.pool import Workers
from casa_assets.show.stills.studio import View
from casa_assets.textures.run.recipes import available_finishes, finishes, finishes_key, skins

WORKER_BYTES = 1_500_000_000  # of memory, that building and checking a member may take
# A picture for the thumbnail alone.
PREVIEW_VIEW = View(size_px=asset_package.THUMBNAIL_PX, passes=8)


@dataclass(frozen=True)
class FamilyRequest:
    """One member to be built: a preset, or draw number `index` of a seed; `is_object`: of registry/objects/."""

    family: str
    preset: str = ""
    seed: int = 0
    index: int = 0
    is_object: bool = False

    @property
    def title(self) -> str:
        """Name for people, such as `microwave/steel` or `microwave/#3`."""
        return f"{self.family}/{self.preset or f'#{self.index}'}"


@dataclass(frozen=True)
class FamilyResult:
    """Outcome of building one member of a family.

    Attributes:
        asset_id, folder: empty if building failed.
        report: of all checks; None if building failed.
        message: why it failed. is_fault: the failure is a bug in the program; then `message` is a traceback.
        is_kept: an earlier run, or an earlier member of the same numbers, has put it there; then nothing was measured.
        build_s, write_s, draw_s, check_s: wall seconds. cpu_s: processor seconds of all of it. size_bytes: of the
            folder.
    """

    request: FamilyRequest
    asset_id: str = ""
    folder: str = ""
    report: Report | None = None
    message: str = ""
    is_fault: bool = False
    is_kept: bool = False
    build_s: float = 0.0
    write_s: float = 0.0
    draw_s: float = 0.0
    check_s: float = 0.0
    cpu_s: float = 0.0
    size_bytes: int = 0

    @property
    def passed(self) -> bool:
        """True if it was built, now or before, and no check found an error."""
        return self.is_kept or (self.report is not None and self.report.passed)

    @property
    def problems(self) -> tuple[Issue, ...]:
        """Errors first."""
        if self.report is None:
            return ()
        errors = self.report.errors
        return (*errors, *(i for i in self.report.issues if i not in errors))


def requests_for(names: Sequence[str], samples: int, seed: int, presets: bool) -> list[FamilyRequest]:
    """All presets and the first draws of each family. Raises UnknownId."""
    requests: list[FamilyRequest] = []
    for name in names or family_names():
        members = family(name)
        if presets:
            requests += [FamilyRequest(name, preset=p) for p in members.presets]
        requests += [FamilyRequest(name, seed=seed, index=i) for i in range(samples)]
    return requests


def object_requests(names: Sequence[str], count: int, seed: int) -> list[FamilyRequest]:
    """Return the first draws of each category of objects, of all categories if `names` is empty. Raises UnknownId."""
    for name in names:
        object_family(name)
    chosen = names or object_names()
    return [FamilyRequest(name, seed=seed, index=i, is_object=True) for name in chosen for i in range(count)]


def family_of(request: FamilyRequest) -> Family[Any]:
    """The family of a member. Raises UnknownId."""
    return object_family(request.family) if request.is_object else family(request.family)


def params_of(request: FamilyRequest) -> Params:
    """The numbers of a member: a preset, or one drawn by the family's rules. Raises UnknownId."""
    member_family = family_of(request)
    if request.preset:
        if request.preset not in member_family.presets:
            raise UnknownId(f"preset of {request.family}", request.preset, member_family.presets)
        chosen: Params = member_family.presets[request.preset]
        return chosen
    lane = f"{'objects' if request.is_object else 'families'}/{request.family}/{request.index}"
    drawn: Params = member_family.draw(rng_for(request.seed, lane), available_finishes())
    return drawn


def build_asset(member_family: Family[Any], params: Params, cache: Path) -> Asset:
    """The asset of a family's numbers; pictures come from or go to the store at `cache`."""
    known = registry.load()
    supplies = Supplies(finishes(params.finishes, cache), labels_of(member_family), known.densities)
    build, owner = member_family.build, _plugin(member_family.name, member_family.form)
    if owner is not None:
        kind = f"form {member_family.form}" if member_family.form else f"family {member_family.name}"
        build = guarded(owner, kind, build)
    asset = build(params, supplies)
    if not member_family.form:
        return asset
    return complete(asset, params, category_of_family(member_family), known.limits["gripper_m"])


def asset_key(member_family: Family[Any], params: Params) -> str:
    """Key of `build_asset`: of the family's own code, its numbers, labels and densities, and the finishes it shows."""
    code = _code_key("" if member_family.form else member_family.name, member_family.form)
    known = registry.load()
    densities = sorted(known.densities.items())
    values: list[Any] = [params.digest, labels_of(member_family).digest, densities, finishes_key(params.finishes)]
    if member_family.form:
        values += [key_of(complete), category_of_family(member_family).digest, known.limits["gripper_m"]]
    return digest_of("asset", member_family.name, code, *values)


@read_once
def _code_key(name: str, form: str) -> str:
    owner = _plugin(name, form)
    if owner is not None:
        return digest_of("plug-in", owner.digest, key_of(assemble))
    row = FORMS[form] if form else MODELS[name]
    return digest_of(key_of(*modules_of(row)), row.contract or "", row.base)


def _plugin(name: str, form: str) -> LoadedPlugin | None:
    """Return the plug-in that a family, or a form of objects, belongs to; None if it belongs to this package."""
    owner = plugin_forms().get(form) if form else plugin_families().get(name)
    return None if owner is None else owner[0]


def modules_of(member_family: Family[Any]) -> tuple[ModuleType, ...]:
    """The modules that hold the numbers of a family of the package, or of a form of objects, and what builds it."""
    names = {member_family.params.__module__, member_family.add_parts.__module__}
    return tuple(sys.modules[name] for name in sorted(names))


def labels_of(member_family: Family[Any]) -> Labels:
    """Category, classes and Wikidata item of a family's assets, from the registry."""
    data = registry.load()
    category = category_of_family(member_family)
    return Labels(category=category.id, classes=data.classes_of(category), qcode=category.qcode)


def category_of_family(member_family: Family[Any]) -> Category:
    """The row of a family's category: of an object in categories.yaml, else in fixtures.yaml."""
    data = registry.load()
    return (data.categories if member_family.form else data.fixtures)[member_family.category]


def build_one(request: FamilyRequest, library: Path, checked: bool = True, drawn: bool = True) -> FamilyResult:
    """Build, write and check one member; its folder is put in the library if it passes, and left out otherwise.

    A fault of a family is reported in `message`, so that the others go on. Starts no process. Raises OutputError: the
    library cannot be written to. NoRenderer: this machine cannot draw.
    """
    return attempt(
        lambda: _build_one(request, Library(library), checked, drawn),
        lambda message, is_fault: FamilyResult(request, message=message, is_fault=is_fault),
        library,
    )


def _build_one(request: FamilyRequest, library: Library, checked: bool, drawn: bool) -> FamilyResult:
    member_family = family_of(request)
    params = params_of(request)
    begin, cpu_before = time.perf_counter(), time.process_time()
    asset = build_asset(member_family, params, cache_for(library.root))
    built = time.perf_counter()
    staged = library.stage(asset.id)
    drawn_s = asset_package.write_package(asset, staged, asset_package.PREVIEW if drawn else PREVIEW_VIEW)
    (staged / "params.json").write_text(params.to_json() + "\n", encoding="utf-8")
    report, written = Report(subject=asset.id), time.perf_counter()
    if checked:
        report = asset_package.check_package(asset, staged, category_of_family(member_family))
        if request.is_object:
            report = report + check_member(asset, category_of_family(member_family), cache_for(library.root))
    checked_s = time.perf_counter() - written
    size = sum(p.stat().st_size for p in staged.rglob("*") if p.is_file())
    target = library.folder(member_family.name, asset.id)
    if report.passed:
        # Producer, cache key and versions for the certificate of a member.
        owner = _plugin(member_family.name, member_family.form)
        if owner is None:
            versions = versions_of({"family": modules_of(member_family), **asset_package.WRITING})
        else:
            versions = {**versions_of(asset_package.WRITING), f"plugin:{owner.plugin.name}": owner.version}
        made_by = MadeBy(Producer.FAMILY, _entry_key(member_family, params, drawn), versions)
        write_certificate(staged, asset, asset_package.certificate(asset, report, staged, made_by))
        library.publish(staged, target)
    return FamilyResult(
        request,
        asset.id,
        str(target if report.passed else staged),
        report,
        build_s=built - begin,
        write_s=written - built - drawn_s,
        draw_s=drawn_s,
        check_s=checked_s,
        cpu_s=time.process_time() - cpu_before,
        size_bytes=size,
    )


def _entry_key(member_family: Family[Any], params: Params, drawn: bool) -> str:
    """Key of a member's entry in a library: what it is made of and by, and how it is drawn."""
    size_px = (asset_package.PREVIEW if drawn else PREVIEW_VIEW).size_px
    return digest_of("family", asset_key(member_family, params), _writing_key(), size_px)


@read_once
def _writing_key() -> str:
    return key_of(asset_package.write_package, asset_package.check_package, check_member, asset_package.certificate)


def summary(results: Sequence[FamilyResult]) -> list[tuple[str, ...]]:
    """Rows of a table: family, passed, of how many, medians of those built now (wall s, processor s, MB); last: all."""
    rows = []
    names = sorted({r.request.family for r in results})
    for name in [*names, ""]:
        members = [r for r in results if not name or r.request.family == name]
        built = [r for r in members if r.report]
        figures = [(r.build_s, r.write_s, r.draw_s, r.check_s, r.cpu_s, r.size_bytes / 1e6) for r in built]
        medians = [f"{median(column):.3f}" for column in zip(*figures, strict=True)]
        rows.append((name or "all", str(sum(r.passed for r in members)), str(len(members)), *(medians or [""] * 6)))
    return rows


def build_all(
    wanted: Sequence[FamilyRequest], library: Path, jobs: Workers = 0, drawn: bool = True
) -> Iterator[FamilyResult]:
    """Yield members as they are finished, each built in a worker; then the reports of the library are written.

    Members that an earlier run has built under the same key are yielded first and stay unchanged. Raises OutputError:
    the library is held by another run or cannot be written. CasaError: see run_batch.
    """
    place = Library(library)
    with place.locked(), writing(library):
        place.sweep()
        due: list[FamilyRequest] = []
        for request, kept in _compared(wanted, place, drawn):
            if kept is None:
                due.append(request)
            else:
                yield kept
        build = partial(build_one, library=library, drawn=drawn)
        for number, answer in run_batch(build, due, library, jobs, warm, WORKER_BYTES):
            if isinstance(answer, WorkerFailure):
                yield FamilyResult(due[number], message=answer.text, is_fault=True)
            else:
                yield answer
        write_reports(place)


def _compared(
    wanted: Sequence[FamilyRequest], library: Library, drawn: bool
) -> Iterator[tuple[FamilyRequest, FamilyResult | None]]:
    """Each request, and its result where an earlier run, or an earlier request of the same numbers, gives it."""
    known = {entry.path: entry for entry in EntryTable(library, skip_damaged=True).entries}
    asked: set[str] = set()
    for request in wanted:
        member_family, params = family_of(request), params_of(request)
        asset_id = Identity(Producer.FAMILY, params.digest).asset_id(member_family.name)
        folder = library.folder(member_family.name, asset_id)
        entry = known.get(folder.relative_to(library.root).as_posix())
        is_there = entry is not None and entry.is_whole and entry.cache_key == _entry_key(member_family, params, drawn)
        kept = FamilyResult(request, asset_id, str(folder), is_kept=True) if is_there or asset_id in asked else None
        asked.add(asset_id)
        yield request, kept


def warm() -> None:
    """Load what every worker needs, once for all of them; nothing here may draw."""
    registry.load()
    simready.warm()
    load_table()
    available_finishes()
    object_names()
    # Keys of the code that builds, paints, writes and checks: reading all of it takes seconds.
    for form in FORMS:
        _code_key("", form)
    finishes_key(skins())
    versions_of(asset_package.WRITING)
    key_of(complete)
    _writing_key()
    run_checks(None, "", {})  # of what no check is about: imports the table of checks


# Two members have the same proportions where the logarithms of these fall into one step of this width: about a sixth.
PROPORTION_STEP = 0.15


def complete(asset: Asset, params: Params, category: Category, opening_m: float) -> Asset:
    """The object with its split, and with a site `grasp_<feature>` for each way in which a hand can take it."""
    split = split_of(shape_digest(asset, params))
    grasps = tuple(grasp_site(grasp, np.zeros(3)) for grasp in _grasps(asset, category, opening_m))
    return asset.replace(labels=asset.labels.replace(split=split), sites=(*asset.sites, *grasps))


def shape_digest(asset: Asset, params: Params) -> str:
    """64 hex digits that members of a category share where they have the same design and about the same proportions.

    Colours, labels and what is random in a surface have no part in it, and neither has the size.
    """
    x, y, z = (float(side) for side in np.ptp(asset.bounds, axis=0))
    proportions = [round(math.log(ratio) / PROPORTION_STEP) for ratio in (y / x, z / x)]
    return digest_of("shape", asset.labels.category, params.design, proportions)


def _grasps(asset: Asset, category: Category, opening_m: float) -> tuple[Grasp, ...]:
    """Grasps of the root link: what takes a lid lifts the lid and not the pot."""
    root = asset.root
    parts = [visual.mesh for visual in root.visuals]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in parts[:-1])])
    points, point_of_vertex = weld(np.concatenate([mesh.vertices for mesh in parts]).astype(np.float64))
    faces = np.concatenate([mesh.faces.astype(np.int64) + start for mesh, start in zip(parts, starts, strict=True)])
    return choose_grasps(points, point_of_vertex[faces], root.inertial.center_of_mass, category, opening_m)


def check_member(asset: Asset, category: Category, cache: Path) -> Report:
    """The report of the checks on members of objects."""
    member = ObjectMember(asset, category, printed_lines(asset, cache))
    records = registry.load()
    return run_checks(member, asset.id, records.limits, records.waived(asset.id), objects.ROWS)


def printed_lines(asset: Asset, cache: Path) -> dict[str, tuple[PrintedLine, ...]]:
    """Printed lines, brand and first word, of materials with a label, by their ids; cache: folder of the store."""
    found = {}
    for material in asset.materials:
        recipe, picture = skins().get(material.id), material.base_color_texture
        kind = None if recipe is None else texture_kinds().get(recipe.kind)
        if recipe is not None and picture is not None and kind is not None and kind.printed_lines is not None:
            store, size = Store(cache / "printed_lines", is_optional=True), (picture.height_px, picture.width_px)
            key = digest_of("printed_lines", key_of(kind.printed_lines), recipe.digest, size)
            kept = store.get(key)
            if kept is None:
                made = kind.printed_lines(kind.params.from_json(recipe.params), size)
                rows = [
                    {"text": x.text, "runs_upwards": x.runs_upwards, "png": _png(np.asarray(x.cover))} for x in made
                ]
                kept = json.dumps(rows, sort_keys=True).encode()
                store.put(key, kept)
            found[material.id] = _read(kept)
    return found


@lru_cache(maxsize=64)
def _read(kept: bytes) -> tuple[PrintedLine, ...]:
    found = []
    for row in json.loads(kept):
        with Image.open(io.BytesIO(base64.b64decode(row["png"]))) as image:
            found.append(PrintedLine(row["text"], np.asarray(image) / 255.0, row["runs_upwards"]))
    return tuple(found)


def _png(cover: Floats) -> str:
    out = io.BytesIO()
    Image.fromarray(np.rint(255 * cover).astype(np.uint8)).save(out, "PNG")
    return base64.b64encode(out.getvalue()).decode()
