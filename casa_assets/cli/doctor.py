"""Check this machine: installed packages, renderers, disk and memory, and the command that fixes what is missing."""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from casa_assets.checks.simready_python import EXTRA as SIMREADY
from casa_assets.checks.simready_python import (
    NEEDED,
    NEWEST_PYTHON,
    NoVerdict,
    how_to_install,
    validator_python,
    validator_versions,
)
from casa_assets.core.system import extras, install_command, requirements
from casa_assets.errors import CasaError
from casa_assets.model.record import Record
from casa_assets.projects import data_root, project_folder
from casa_assets.registry.load import load
from casa_assets.registry.plugins import ignored_files, load_plugins
from casa_assets.registry.project_files import files_of
from casa_assets.registry.read import load_project
from casa_assets.show.stills.opengl import BACKENDS as RENDERERS
from casa_assets.show.stills.opengl import install_line, why_not

ROOT = Path(__file__).parents[2]  # of a checkout
CHILD_LIMIT_S = 90.0
FREE_DISK_BYTES = 2 * 1024**3  # a library of a thousand assets with pictures takes about this much
MEMORY_BYTES = 3 * 1024**3  # convex decomposition of a large mesh needs about this much

# Modules with compiled code, whose import alone shows that this machine can load them, and their distributions.
NATIVE_MODULES = {
    **{name: name for name in ("coacd", "manifold3d", "meshoptimizer", "mujoco", "numpy", "pyarrow", "vhacdx")},
    "lxml.etree": "lxml",
    "opengl_decimate": "opengl-decimate",
    "PIL.Image": "pillow",
    "pxr.Usd": "usd-core",
    "scipy.spatial": "scipy",
    "simready.foundation.tier_core": "simready-foundation-tier-core",
    "simready.validate": "simready-validate",
}

# A line of constraints.txt, such as numpy==2.4.6, or usd-core==26.11 ; python_version >= "3.14".
_PIN = re.compile(
    r"""(?P<name>[\w.-]+)==(?P<version>[^\s;]+)(\s*;\s*python_version\s*(?P<order><|>=)\s*"3\.(?P<minor>\d+)")?$"""
)

_DRAW = """
import mujoco
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><light pos='0 0 2'/><geom size='.3' rgba='1 1 1 1'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, 8, 8) as renderer:
    renderer.update_scene(data)
    picture = renderer.render()
    from OpenGL import GL
    name = GL.glGetString(GL.GL_RENDERER).decode()
assert picture.max() > 0, "the picture is black"
print(name)
"""

_IMPORT = """
import importlib, json, sys
bad = {}
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
    except BaseException as error:
        bad[name] = f"{type(error).__name__}: {error}".splitlines()[0]
print(json.dumps(bad))
"""


class Finding(Record):
    """One thing that was looked at, such as `renderer egl`, and the command that fixes it, if one does.

    `needed`: the program does not work as documented without it.
    """

    subject: str
    ok: bool
    needed: bool = True
    message: str
    fix: str = ""


def _note(subject: str, ok: bool, message: str, fix: str = "") -> Finding:
    return Finding(subject=subject, ok=ok, needed=False, message=message, fix="" if ok else fix)


def findings(output: Path) -> tuple[Finding, ...]:
    """All findings about this machine, in a fixed order; the folder to write to need not exist and is not made."""
    with ThreadPoolExecutor(max_workers=3) as pool:
        drawn = [(name, pool.submit(_draws, name)) for name in RENDERERS]
        loaded = pool.submit(_native)
        renderers = [(name, *future.result()) for name, future in drawn]
        native = loaded.result()
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return (
        _python(),
        *_packages(),
        _simready(),
        native,
        *_renderers(renderers),
        *_folder(output),
        _note("memory", memory >= MEMORY_BYTES, f"{memory / 1024**3:.1f} GiB, {cores} cores"),
        Finding(subject="registry", ok=True, message=f"{data_root()}, which a project is laid over"),
        *_project(),
        *_plugins(),
    )


def _plugins() -> Iterator[Finding]:
    try:
        loaded, left_out = load_plugins(), ignored_files()
    except CasaError as error:
        yield Finding(subject="plug-ins", ok=False, message=str(error))
        return
    for one in loaded:
        yield Finding(subject=f"plug-in {one.plugin.name}", ok=True, message=f"{one.version}, {one.where}")
    if left_out:
        names = ", ".join(path.name for path in left_out)
        yield _note("plug-ins", False, f"{names} of the project do not run; --plugins lets them")


def _project() -> Iterator[Finding]:
    """Which files of the project in use override or extend those of the package; nothing without a project."""
    if (folder := project_folder()) is None:
        return
    try:
        loaded = load_project()
        load()
    except CasaError as error:
        yield Finding(subject="project", ok=False, message=str(error))
        return
    assert loaded is not None
    names = [path.relative_to(folder).as_posix() for path in files_of(folder)]
    packs = [path.parent.relative_to(folder).as_posix() for path in sorted(folder.glob("textures/*/pack.json"))]
    laid = f"lays {', '.join(names)} over those of casa-assets" if names else "lays nothing over casa-assets"
    shown = f"; texture packs: {', '.join(packs)}" if packs else ""
    yield Finding(subject="project", ok=True, message=f"{loaded[0].name} in {folder} {laid}{shown}")


def renderer() -> str | None:
    """The first of RENDERERS that draws a picture here without a screen, as MUJOCO_GL names it, or None."""
    return next((name for name in RENDERERS if _draws(name)[0]), None)


def _fix_packages(names: Iterable[str] = ()) -> str:
    """Return the command that reinstalls the named packages, or all that this one depends on if `names` is empty."""
    if (ROOT / "dev").is_file():
        return "./dev setup"
    wanted = set(names)
    lines = [line for line in requirements() if not wanted or _name(line) in wanted]
    return f"{shlex.quote(sys.executable)} -m pip install --force-reinstall {shlex.join(lines)}"


def _child(code: str, *arguments: str, **environment: str) -> tuple[bool, str]:
    """Run `python -c code` in a child; returns its success and its last line of output. A crash stays there."""
    words, variables = [sys.executable, "-c", code, *arguments], {**os.environ, **environment}
    try:
        done = subprocess.run(words, env=variables, capture_output=True, text=True, timeout=CHILD_LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return False, f"no answer within {CHILD_LIMIT_S:g} s"
    lines = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines()
    return done.returncode == 0, lines[-1] if lines else f"exit code {done.returncode}"


def _draws(name: str) -> tuple[bool, str]:
    return _child(_DRAW, MUJOCO_GL=name, PYOPENGL_PLATFORM=name)


def _python() -> Finding:
    ok = (3, 11) <= sys.version_info[:2] <= (3, 14)
    fix = "" if ok else "sudo apt-get install -y python3 python3-venv && PYTHON=python3 ./dev setup"
    return Finding(subject="python", ok=ok, message=f"{platform.python_version()} ({sys.executable})", fix=fix)


def _packages() -> Iterator[Finding]:
    """Whether distributions are installed, in the pinned versions; those of extras are optional."""
    pinned = _pinned()
    optional = {_name(line): extra for extra, lines in extras().items() if extra != SIMREADY for line in lines}
    for name, extra in (*((name, "") for name in sorted(set(map(_name, requirements())))), *optional.items()):
        subject, version, fix = f"package {name}", _version(name), _fix_packages([name])
        if version is None and extra:
            message = f"not installed, optional: the extra '{extra}' brings it"
            yield _note(subject, False, message, install_command(extra))
        elif version is None:
            yield Finding(subject=subject, ok=False, message="not installed", fix=fix)
        elif version != pinned.get(name, version):
            # Another version may well work, so this is a note, and not held against the machine.
            yield _note(subject, False, f"{version}, tested with {pinned[name]}", fix)
        else:
            yield Finding(subject=subject, ok=True, needed=not extra, message=version)


def _simready() -> Finding:
    try:
        python = validator_python()
    except NoVerdict as missing:
        is_new = sys.version_info[:2] > NEWEST_PYTHON
        fix = how_to_install() if is_new else install_command(SIMREADY)
        return _note("SimReady validator", False, f"{missing}; without it USD002 and SCN020 are not run", fix)
    where = f"by {python}" if python else "in this Python"
    return _note("SimReady validator", True, f"{validator_versions()[NEEDED[0]]}, {where}")


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _pinned() -> dict[str, str]:
    """Normalised name -> version of constraints.txt; empty away from a checkout."""
    path = ROOT / "constraints.txt"
    found = {}
    for pin in map(_PIN.match, path.read_text(encoding="utf-8").splitlines() if path.is_file() else ()):
        if pin is not None:
            is_older = pin["minor"] is not None and sys.version_info[:2] < (3, int(pin["minor"]))
            if pin["minor"] is None or is_older == (pin["order"] == "<"):
                found[_name(pin["name"])] = pin["version"]
    return found


def _name(requirement: str) -> str:
    word = re.split(r"[\s\[<>=!~;]", requirement.strip(), maxsplit=1)[0]
    return re.sub(r"[-_.]+", "-", word).lower()


def _native() -> Finding:
    """Whether compiled modules load: all but those of optional packages that are not installed."""
    left_out = {_name(line) for lines in extras().values() for line in lines if _version(_name(line)) is None}
    modules = {module: name for module, name in NATIVE_MODULES.items() if name not in left_out}
    ran, answer = _child(_IMPORT, *modules)
    message, fix = f"importing them failed: {answer}", _fix_packages()
    if ran:
        bad: dict[str, str] = json.loads(answer)
        message = "; ".join(f"{modules[name]}: {why}" for name, why in bad.items()) or f"{len(modules)} load"
        fix = _fix_packages(_name(modules[name]) for name in bad) if bad else ""
    return Finding(subject="native modules", ok=not fix, message=message, fix=fix)


def _renderers(drawn: Sequence[tuple[str, bool, str]]) -> Iterator[Finding]:
    works = next((name for name, ok, _ in drawn if ok), None)
    but = f"; not needed, for {works} draws" if works else ""
    for name, ok, answer in drawn:
        yield _note(f"renderer {name}", ok, answer if ok else why_not(name, answer) + but)
    message = f"{works} is used" if works else "none works, so there would be no pictures"
    yield Finding(subject="rendering", ok=works is not None, message=message, fix="" if works else install_line())


def _folder(output: Path) -> Iterator[Finding]:
    folder = output.absolute()
    while not folder.exists():
        folder = folder.parent
    message, fix = f"{output} can be {'written' if output.exists() else 'made'}", ""
    if not folder.is_dir() or not os.access(folder, os.W_OK | os.X_OK):
        message = f"{folder} is not writable"
        fix = f"sudo chown -R $USER {folder}" if folder.is_dir() else "choose another --out"
    yield Finding(subject="output folder", ok=not fix, message=message, fix=fix)
    free = shutil.disk_usage(folder).free
    enough = free >= FREE_DISK_BYTES
    advice = "" if enough else f", {FREE_DISK_BYTES / 1024**3:.0f} GiB are advised"
    yield _note("disk", enough, f"{free / 1024**3:.1f} GiB free{advice}")
