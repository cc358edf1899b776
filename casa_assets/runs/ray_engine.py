"""Run jobs on a Ray cluster: Ray chooses the machine by free processors and memory, each machine isolates its jobs.

Ray's own retries are off. A job is tried again only where its machine or the process that Ray had started for it is
lost, which is no fault of the job; what the job itself does is answered by `ray_node`.
"""

from __future__ import annotations

import logging
import math
import os
import re
import secrets
import socket
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import ray
from ray import exceptions
from ray._private import worker as ray_worker

from casa_assets.errors import CasaError
from casa_assets.projects import plugin_use, project_folder
from casa_assets.runs import ray_node as node
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.pool import Engine, RayCluster, Step, address_of

LOG = logging.getLogger(__name__)

# A job whose process is killed may be what kills it; machines are lost for reasons of their own.
MAX_CRASHES, MAX_LOST_MACHINES = 2, 5
# Jobs that wait on a cluster beside those that run, as a part of them: no processor waits for the leading process.
WAITING_SHARE = 0.125
KNOCK_S = 10.0  # for an answer from a cluster
LOOK_S = 2.0  # between two looks at the size of the cluster
OBJECT_STORE_BYTES = 200_000_000  # of a Ray that we start: jobs and answers are small, and files go over the disk
LOST_MACHINE = (exceptions.NodeDiedError, exceptions.ObjectLostError)
# Where Ray's own process on the leading machine ends, the run connects anew, so often at most, each time within:
MAX_CONNECTIONS, CONNECT_S = 5, 60.0
# Seconds without an answer after which the head of a cluster is given up: less than the 60 after which Ray would end
# this process with an exit code that means something else here.
HEAD_S = 40.0


@dataclass
class _Queue:
    """Jobs by number: those to be done, those that run with their memory by Ray's reference, and what befell them."""

    waiting: deque[int]
    running: dict[Any, tuple[int, int]] = field(default_factory=dict)
    with_all_memory: set[int] = field(default_factory=set)
    crashes: Counter[int] = field(default_factory=Counter)
    lost: Counter[int] = field(default_factory=Counter)


class RayEngine(Engine):
    """Jobs of one run on a Ray cluster.

    A job is started with as much memory as each of a machine's processors has its share of; one for which that is not
    enough is tried once more with all that it may use, as in the local pool.

    Args:
        limits: of each job. warm, least_bytes: as in Pool.
        shared: folder on a disk that all machines share, for files of the run alone.
    Raises:
        CasaError: no cluster answers, or a machine of it is unfit (another version, no shared disk); from `run`.
    """

    def __init__(self, cluster: RayCluster, limits: Limits, warm: Step, shared: Path, least_bytes: int) -> None:
        self._cluster, self._limits, self._least_bytes = cluster, limits, least_bytes
        super().__init__(warm)
        self._marker = Path(os.path.abspath(shared)) / f"cluster-{secrets.token_hex(8)}"  # noqa: PTH100
        self._is_ours = False
        self._is_connected = False
        self._seen: list[tuple[int, int]] = []
        self._seen_at = -math.inf
        self._connections = 1
        self._head = ""
        self._head_seen_at = math.inf
        self._full: dict[str, str] = {}  # messages of machines whose disk is full, by Ray's id of them

    def close(self) -> None:
        """End what runs, and the cluster where it was started here."""
        with suppress(OSError):
            self._marker.unlink(missing_ok=True)
        if self._is_ours:
            ray.shutdown()
        self._is_ours = self._is_connected = False

    def run(
        self, function: Step, jobs: Sequence[Any], started: Callable[[int], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """See Engine; a job has started when it is handed to the cluster."""
        if not jobs:
            return
        self._connect()
        order = self._order(address_of(function))
        queue = _Queue(deque(range(len(jobs))))
        try:
            while queue.waiting or queue.running:
                self._look_for_head(queue)
                share, at_once = self._room()
                while queue.waiting and len(queue.running) < at_once:
                    number = queue.waiting.popleft()
                    memory = self._most_memory() if number in queue.with_all_memory else share
                    queue.running[self._submit(order, jobs[number], memory)] = number, memory
                    if started is not None:
                        started(number)
                ready, _ = ray.wait(list(queue.running), num_returns=1, timeout=LOOK_S)
                for reference in ready:
                    number, memory = queue.running.pop(reference)
                    try:
                        answer = self._answer(reference, number, queue, memory)
                    except exceptions.LocalRayletDiedError as error:
                        queue.waiting.appendleft(number)
                        self._connect_again(queue, error)
                        break
                    if answer is not None:
                        yield number, answer[0]
        finally:
            for reference in queue.running:
                with suppress(Exception):
                    ray.cancel(reference, force=True)

    def _submit(self, order: node.Order, job: Any, memory: int) -> Any:
        fit = {"ray.io/node-id": f"!in({','.join(sorted(self._full))})"} if self._full else None
        task = ray.remote(node.work).options(
            num_cpus=1, memory=memory, max_retries=0, retry_exceptions=False, label_selector=fit
        )
        return task.remote(replace(order, limits=replace(self._limits, memory_bytes=memory)), job)

    def _leave_out(self, full: node.Full) -> None:
        """Give no more jobs to a machine. Raises CasaError where it is the last one."""
        if full.node not in self._full:
            LOG.warning("a machine of the cluster gets no more jobs: %s", full.message)
        self._full[full.node] = full.message
        self._seen_at = -math.inf
        if not self._machines():
            raise CasaError("no machine of the cluster has room on its disk:\n" + "\n".join(self._full.values()))

    def _order(self, function: str) -> node.Order:
        self._marker.parent.mkdir(parents=True, exist_ok=True)
        self._marker.touch()
        warm = tuple(self._warm)
        version, uses = node.version(), (project_folder(), plugin_use())
        return node.Order(function, warm, self._limits, self._least_bytes, Path.cwd(), self._marker, version, *uses)

    def _answer(self, reference: Any, number: int, queue: _Queue, memory: int) -> tuple[Any] | None:
        """Return the answer of a job that has ended, or None if it is put back into the queue. Raises CasaError."""
        try:
            answer = ray.get(reference)
        except exceptions.OutOfMemoryError:
            answer = WorkerFailure("memory", f"needs more than {memory / 1e9:.3g} GB of memory")
        except exceptions.RayTaskError as error:
            raise CasaError(f"a machine of the cluster cannot do its jobs: {error.cause}") from error
        except exceptions.WorkerCrashedError:
            queue.crashes[number] += 1
            if queue.crashes[number] < MAX_CRASHES:
                queue.waiting.appendleft(number)
                return None
            answer = WorkerFailure("killed", "the process was ended from outside, twice")
        except LOST_MACHINE as error:
            queue.lost[number] += 1
            if queue.lost[number] < MAX_LOST_MACHINES:
                queue.waiting.appendleft(number)
                return None
            answer = WorkerFailure("killed", f"{MAX_LOST_MACHINES} machines were lost while they did it ({error})")
        if isinstance(answer, node.Unfit):
            raise CasaError(answer.message)
        if isinstance(answer, node.Full):
            self._leave_out(answer)
            queue.waiting.appendleft(number)
            return None
        is_short = isinstance(answer, WorkerFailure) and answer.reason == "memory"
        if is_short and number not in queue.with_all_memory and memory < self._most_memory():
            queue.with_all_memory.add(number)
            queue.waiting.append(number)
            return None
        return (answer,)

    def _connect(self) -> None:
        """Connect to the cluster, or start one on this machine."""
        if self._is_connected:
            return
        if not ray.is_initialized():
            os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # no request leaves the machine
            address = self._cluster.address
            own: dict[str, Any] = {
                "num_cpus": self._cluster.most or len(os.sched_getaffinity(0)),
                "include_dashboard": False,
                "object_store_memory": OBJECT_STORE_BYTES,
            }
            try:
                _knock(address)
                ray.init(
                    address or "local", log_to_driver=False, logging_level=logging.ERROR, **({} if address else own)
                )
            except (OSError, RuntimeError, ValueError) as error:
                place = f"at {address}" if address else "on this machine"
                message = f"no Ray cluster answers {place}: {error}; start one with `ray start --head`"
                raise CasaError(message) from error
            # Ray prints what becomes of its processes to standard output, among the rows of --json, whatever
            # log_to_driver says. The run tells it in its own words.
            ray_worker._worker_logs_enabled = False
            self._is_ours = True
        self._is_connected = True
        self._head = ray.get_runtime_context().gcs_address
        self._head_seen_at = time.monotonic()
        if not self._machines():
            self.close()
            raise CasaError(f"the cluster at {self._cluster.address} has no processors; start workers with `ray start`")

    def _connect_again(self, queue: _Queue, error: Exception) -> None:
        """Connect again and put all running jobs back into the queue: Ray answers every job with an error from now on.

        Raises:
            CasaError: no cluster answers, the connection keeps breaking, or it is not ours.
        """
        self._connections += 1
        if not self._is_ours or self._connections > MAX_CONNECTIONS:
            message = "Ray has ended on the machine that leads the run; start it again, then run the same command again"
            raise CasaError(message) from error
        LOG.warning("Ray has ended on the machine that leads the run; connecting again")
        queue.waiting.extendleft(sorted((number for number, _ in queue.running.values()), reverse=True))
        queue.running.clear()
        ray.shutdown()
        self._is_ours = self._is_connected = False
        self._seen_at = -math.inf
        give_up = time.monotonic() + CONNECT_S
        while not self._is_connected:
            try:
                self._connect()
            except CasaError:
                if time.monotonic() > give_up:
                    raise
                time.sleep(LOOK_S)

    def _look_for_head(self, queue: _Queue) -> None:
        """Wait where the head of the cluster does not answer. Raises CasaError where it does not come back."""
        while time.monotonic() - self._head_seen_at > LOOK_S:
            try:
                _knock(self._head)
            except OSError as error:
                if time.monotonic() - self._head_seen_at > HEAD_S:
                    queue.running.clear()  # to cancel them would wait for the head
                    message = "is lost; start Ray again, then run the same command again"
                    raise CasaError(f"the head of the cluster at {self._head} {message}") from error
                time.sleep(LOOK_S)
            else:
                self._head_seen_at = time.monotonic()

    def _machines(self) -> list[tuple[int, int]]:
        """Processors and bytes of memory of each machine that takes jobs; not asked for again within `LOOK_S`."""
        if time.monotonic() - self._seen_at > LOOK_S:
            known = [one for one in ray.nodes() if one["Alive"] and one["NodeID"] not in self._full]
            resources = [one["Resources"] for one in known]
            self._seen = [(int(one["CPU"]), int(one.get("memory", 0))) for one in resources if one.get("CPU", 0) >= 1]
            self._seen_at = time.monotonic()
        return self._seen

    def _room(self) -> tuple[int, int]:
        """Bytes for each job, and how many jobs the cluster is given at once."""
        machines = self._machines()
        share = min((memory // processors for processors, memory in machines), default=self._least_bytes)
        share = min(self._limits.memory_bytes, max(self._least_bytes, share))
        slots = sum(max(1, min(processors, memory // share)) for processors, memory in machines)
        return share, self._cluster.most or slots + math.ceil(WAITING_SHARE * slots)

    def _most_memory(self) -> int:
        """Bytes that a job may have at most: its limit, or all that the largest machine gives."""
        return min(self._limits.memory_bytes, max((memory for _, memory in self._machines()), default=0))


def _knock(address: str) -> None:
    """Raise OSError where nothing listens at host:port; Ray would try for minutes."""
    if found := re.fullmatch(r"(?:ray://)?\[?([^/\[\]]+)\]?:(\d+)", address):
        socket.create_connection((found[1], int(found[2])), KNOCK_S).close()
