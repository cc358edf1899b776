"""Run one job on a machine of a Ray cluster, in a separate child process with limits, as on one machine.

A process that Ray starts keeps a pool of one worker from job to job, with the modules that all jobs need loaded once. A
job that crashes, runs out of memory or hangs ends its child alone, and the answer says so.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import platform
import re
import socket
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from casa_assets.core.system import requirements
from casa_assets.errors import CasaError
from casa_assets.projects import (
    PluginUse,
    choose_plugins,
    data_root,
    plugin_use,
    project_folder,
    read_once,
    use_project,
)
from casa_assets.registry.plugins.load import load_plugins
from casa_assets.registry.project_files import files_of
from casa_assets.runs.limits import Limits, full_disk
from casa_assets.runs.pool import Pool

# Seconds that a new file may take to be seen through a shared disk; NFS keeps what it knows of a folder for up to 60 s,
# but looks again where a name is not known.
SHARED_DISK_S = 10.0
PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True)
class Order:
    """Settings shared by all jobs of a run.

    Attributes:
        function: `module:name` of the function of one argument that does a job. warm: as in Pool, in their order.
        limits: of each job. least_bytes: minimum memory that a job needs.
        folder: working folder of the run, to which paths in jobs are relative.
        marker: file that the run has written on the shared disk.
        project: folder of the project in use, on the shared disk; None if no project is in use.
        plugins: which plug-ins run.
    """

    function: str
    warm: tuple[str, ...]
    limits: Limits
    least_bytes: int
    folder: Path
    marker: Path
    version: str
    project: Path | None = None
    plugins: PluginUse = PluginUse.INSTALLED


@dataclass(frozen=True)
class Unfit:
    """Why this machine cannot do the jobs of a run."""

    message: str


@dataclass(frozen=True)
class Full:
    """This machine has no room for the temporary files of a job; others may.

    Attributes:
        message: where, how much room is left, and what to do.
    """

    node: str
    message: str


# Pools of this process by their limits, each with the number of functions that it has been warmed with.
_pools: dict[tuple[Limits, int], tuple[Pool, int]] = {}
_checked: set[tuple[str, Path]] = set()


@read_once
def version() -> str:
    """Digest of this package with its registry and the project in use, of what packages it needs, and of Python."""
    digest = hashlib.sha256(platform.python_version().encode())
    roots = {root: sorted(root.rglob("*")) for root in (PACKAGE, data_root())}
    if (project := project_folder()) is not None:
        roots[project] = list(files_of(project))
    for one in load_plugins():
        digest.update(f"{one.plugin.name} {one.digest}\0".encode())
    for root, paths in roots.items():
        for path in paths:
            if path.is_file() and "__pycache__" not in path.parts:
                digest.update(path.relative_to(root).as_posix().encode() + b"\0")
                digest.update(hashlib.sha256(path.read_bytes()).digest())
    for line in requirements():
        name = re.split(r"[^\w.-]", line, maxsplit=1)[0]
        digest.update(f"{name} {importlib.metadata.version(name)}\0".encode())
    return digest.hexdigest()


def work(order: Order, job: Any) -> Any:
    """Do one job on this machine: what it answers, a WorkerFailure, Unfit, or Full.

    An answer that was found while the disk filled up is not trusted: a library that cannot write its temporary files
    may say of an input whatever it likes.

    Raises:
        CasaError: no worker can be started.
    """
    if (order.version, order.marker) not in _checked:
        message = _unfit(order)
        if message:
            return Unfit(f"{socket.gethostname()}: {message}")
        os.chdir(order.folder)
        _checked.add((order.version, order.marker))
    answer = None
    if (full := full_disk()) is None:
        ((_, answer),) = _pool(order).run(order.function, [job])
        full = full_disk()
    return answer if full is None else Full(_node_id(), f"{socket.gethostname()}: {full}")


def _node_id() -> str:
    import ray

    return str(ray.get_runtime_context().get_node_id())


def _unfit(order: Order) -> str:
    if (order.project, order.plugins) != (project_folder(), plugin_use()):
        try:
            use_project(order.project)
            choose_plugins(order.plugins)
        except CasaError as error:
            return f"does not see the project of the run: {error}"
    if order.version != version():
        return (
            "has another version of casa-assets, of a package that it uses, or of Python than the machine that started "
            "the run; install the same on all machines (docs/howto/scale.md)"
        )
    give_up = time.monotonic() + SHARED_DISK_S
    while not order.marker.exists():
        if time.monotonic() > give_up:
            return f"does not see {order.marker.parent}; a cluster needs a disk that all machines share"
        time.sleep(0.2)
    if not order.folder.is_dir():
        return f"does not see the working folder {order.folder}; start the run in a folder that all machines share"
    return ""


def _pool(order: Order) -> Pool:
    key = (order.limits, order.least_bytes)
    pool, warmed = _pools.get(key) or (Pool(1, order.limits, order.warm[0], order.least_bytes), 1)
    for warm in order.warm[warmed:]:
        pool.prepare(warm)
    _pools[key] = pool, max(warmed, len(order.warm))
    return pool
