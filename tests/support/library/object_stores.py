"""Servers that speak S3 and keep their data on disk, to be killed and started again, and the program that uses them."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import IO

from casa_assets.runs.limits import trees
from tests.support.library.libraries import ROOT, command, ran
from tests.support.program.environments import packages_of, with_packages_of

KEY, SECRET, BUCKET = "tester", "not-to-be-seen-anywhere", "assets"
READY_S = 60.0


class Server:
    """A server with one bucket on this machine; a context manager.

    Args:
        kind: `rclone`, whose objects are files of a folder, or `seaweedfs`, an object store of volumes.
        folder: of its data, which outlives it.
    """

    def __init__(self, kind: str, folder: Path) -> None:
        self._packages = packages_of("stores")
        self._kind, self._data, self._log = kind, folder / "data", folder / "log.txt"
        self._data.mkdir(parents=True)
        self._ports = [_free_port() for _ in range(8)]
        self._process: subprocess.Popen[bytes] | None = None
        self.url = f"http://127.0.0.1:{self._ports[0]}"

    def __enter__(self) -> Server:
        self.start()
        self.python(f"import s3fs; s3fs.S3FileSystem().mkdir({BUCKET!r})", code=0)
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    def start(self) -> None:
        """Start it, or start it again with the same data."""
        with self._log.open("ab") as log:
            self._process = self._started(log)
        give_up = time.monotonic() + READY_S
        while not self._answers():
            assert self._process.poll() is None, self._log.read_text(errors="replace")[-2000:]
            assert time.monotonic() < give_up, self._log.read_text(errors="replace")[-2000:]
            time.sleep(0.1)

    def kill(self) -> None:
        """End it at once, as by a lost machine."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()

    @property
    def size(self) -> int:
        """Bytes that it keeps on disk; files may come and go meanwhile."""
        total = 0
        for folder, _, names in os.walk(self._data):
            for name in names:
                try:
                    total += os.stat(os.path.join(folder, name)).st_blocks * 512  # noqa: PTH116, PTH118
                except FileNotFoundError:
                    continue
        return total

    @property
    def environment(self) -> dict[str, str]:
        """Of a process that finds the packages of the extra, and this server."""
        return with_packages_of(
            "stores",
            AWS_ACCESS_KEY_ID=KEY,
            AWS_SECRET_ACCESS_KEY=SECRET,
            AWS_ENDPOINT_URL=self.url,
            AWS_DEFAULT_REGION="us-east-1",
            AWS_CONFIG_FILE=os.devnull,
            AWS_SHARED_CREDENTIALS_FILE=os.devnull,
            AWS_EC2_METADATA_DISABLED="true",
        )

    def casa(self, *arguments: object, code: int | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
        variables = {**self.environment, **environment}
        return ran(*command(*arguments), code=code, cwd=ROOT, env=variables, timeout=600)

    def done(self, *arguments: object) -> str:
        return self.casa(*arguments, code=0).stdout

    def begin(self, *arguments: object, **environment: str) -> subprocess.Popen[str]:
        variables, pipe = {**self.environment, **environment}, subprocess.PIPE
        return subprocess.Popen(command(*arguments), cwd=ROOT, env=variables, stdout=pipe, stderr=pipe, text=True)

    def python(self, text: str, code: int | None = None) -> subprocess.CompletedProcess[str]:
        return ran(sys.executable, "-c", text, code=code, env=self.environment)

    def keys(self, folder: str) -> list[str]:
        text = f"import s3fs; print(*s3fs.S3FileSystem().find({f'{BUCKET}/{folder}'!r}), sep='\\n')"
        lines = self.python(text, code=0).stdout.split("\n")
        return sorted(line.removeprefix(f"{BUCKET}/{folder}/") for line in lines if line)

    def _started(self, log: IO[bytes]) -> subprocess.Popen[bytes]:
        s3, *ports = self._ports
        program = self._packages.parents[2] / "bin" / ("rclone" if self._kind == "rclone" else "weed")
        if self._kind == "rclone":
            words = ["serve", "s3", "--addr", f"127.0.0.1:{s3}", "--auth-key", f"{KEY},{SECRET}"]
            words += ["--config", os.devnull, str(self._data)]
        else:
            names = ("s3.port.grpc", "master.port", "master.port.grpc", "volume.port", "volume.port.grpc", "filer.port")
            numbers = dict(zip((*names, "filer.port.grpc"), ports, strict=True))
            words = ["-logtostderr", "server", "-s3", "-ip=127.0.0.1", "-ip.bind=127.0.0.1", f"-s3.port={s3}"]
            words += [f"-{name}={number}" for name, number in numbers.items()]
            words += ["-s3.port.iceberg=0", "-s3.port.lance=0", "-volume.max=16", "-master.volumeSizeLimitMB=64"]
            words += ["-master.telemetry=false", f"-dir={self._data}"]
        return subprocess.Popen([program, *words], stdout=log, stderr=log, start_new_session=True)

    def _answers(self) -> bool:
        code = "import s3fs; s3fs.S3FileSystem(config_kwargs={'connect_timeout': 2}).ls('', refresh=True)"
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", self._ports[0])):
                return False
        return self.python(code).returncode == 0


def killed(run: subprocess.Popen[str]) -> None:
    """End the program at once, with all the processes that it started."""
    for process in trees([run.pid])[run.pid]:
        with suppress(ProcessLookupError):
            os.kill(process.pid, signal.SIGKILL)
    run.communicate()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
