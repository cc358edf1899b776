"""Find cells that differ between the MJCF and the USD of a scene, flat and nested, by two readers of the USD."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import mujoco
import numpy as np
import numpy.typing as npt
from pxr import Tf, Usd

from casa_assets.checks.check import Measurement, Problem, count, not_run
from casa_assets.checks.package.parity import compare, parameter_differences, parameter_table
from casa_assets.checks.readers import scene_facts, usd_facts
from casa_assets.checks.readers.facts import short_name
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.scene_facts import SceneFacts
from casa_assets.checks.scene.forms import SceneFiles

Facts = TypeVar("Facts")

# Of ratios, unit vectors, radians, and masses relative to those of the body, which USD holds as float32.
TOLERANCE = 1e-5
LENGTH_TOLERANCE_M = 2e-6  # a float32 six metres from the origin is right to 2.4e-7
# Numbers of two models that differ by less are the same: the two have a pose in one step and in several.
SAME = 1e-9
# Sizes of a model that hang on how long its names are.
LENGTHS = ("nbuffer", "nnames")


def formats_agree(files: SceneFiles, limit: float) -> Measurement:
    """SCN017: number of differing cells: bodies, poses, joints, masses, shapes, filters, labels, places.

    SCN001 and SCN018 report files that cannot be read.
    """
    missing = usd_facts.missing_importer()
    model, composed = files.scene_subject.loaded.model, (files.composed[0], files.composed_nested[0])
    flat, nested = (None, None) if missing else (files.imported.model, files.imported_nested.model)
    if model is None or composed[0] is None or composed[1] is None or (None in (flat, nested) and not missing):
        return not_run("one of scene.xml, scene.usda and scene_nested.usda cannot be read")
    expected = _read(lambda: scene_facts.facts_of_scene_model(model))
    problems = _differences(model, expected, flat, files.usd, composed[0])
    # What the flat layer says otherwise, the nested one says by reference; that is one fault.
    shared = {at for at, _ in problems}
    # Of a model that is the flat one again MuJoCo would be asked the same twice.
    apart = None if missing or _is_same(flat, nested) else nested
    told = _differences(model, expected, apart, files.nested, composed[1])
    problems += [(f"nested/{at}", said) for at, said in told if at not in shared]
    return not_run(missing, waived=True) if missing and not problems else count(problems, allowed=limit)


def _is_same(first: mujoco.MjModel, second: mujoco.MjModel) -> bool:
    """True where two models are the same numbers, and bodies, joints, geoms and sites have the same short names."""
    for part, other_part in ((first, second), (first.opt, second.opt)):
        for name in dir(part):
            # Where names begin in the text of all names differs: they are paths.
            if name.startswith(("_", "name")) or not isinstance(getattr(part, name), np.ndarray | float | int):
                continue
            one, other = (np.asarray(getattr(each, name)) for each in (part, other_part))
            if name not in LENGTHS and not _are_alike(one, other):
                return False
    counts = {"body": first.nbody, "joint": first.njnt, "geom": first.ngeom, "site": first.nsite}
    return all(
        short_name(getattr(first, kind)(number).name) == short_name(getattr(second, kind)(number).name)
        for kind, count in counts.items()
        for number in range(count)
    )


def _are_alike(one: npt.NDArray[Any], other: npt.NDArray[Any]) -> bool:
    if one.shape != other.shape:
        return False
    return bool((one == other).all()) or float(np.abs(one.astype(float) - other.astype(float)).max()) <= SAME


def _differences(
    mjcf: mujoco.MjModel,
    reading: tuple[SceneFacts | None, str],
    imported: mujoco.MjModel | None,
    usd: Path,
    stage: Usd.Stage,
) -> list[Problem]:
    """Differences between files that MuJoCo has already read.

    Args:
        mjcf: of scene.xml. reading: its table, or the reason why there is none.
        imported: of scene.usda, which lies at `usd`; None leaves what UsdPhysics reads.
        stage: composed of that file, left as it is.
    """
    expected, error = reading
    if expected is None:
        return [("scene.xml", error)]
    problems = []
    if imported is not None:
        rows = parameter_differences(parameter_table(mjcf), parameter_table(imported))
        problems += [row.problem for row in rows if row.exceeds(TOLERANCE)]
    read, error = _read(lambda: scene_facts.SceneReading(stage))
    if read is None:
        return [*problems, (usd.name, error)]
    readers = [lambda: scene_facts.facts_of_stage(read)]
    if imported is not None:
        readers.insert(0, lambda: scene_facts.facts_of_import(imported, read))
    for reader in readers:
        actual, error = _read(reader)
        if actual is None:
            problems.append((usd.name, error))
        else:
            problems += compare(expected, actual, TOLERANCE, LENGTH_TOLERANCE_M)
    # What both readers of the USD find is reported once.
    return list(dict.fromkeys(problems))


def _read(reader: Callable[[], Facts]) -> tuple[Facts | None, str]:
    """Result of a reader, or the reason why it failed."""
    with quiet():
        try:
            return reader(), ""
        except (ValueError, Tf.ErrorException) as error:
            return None, " ".join(str(error).split()) or type(error).__name__
