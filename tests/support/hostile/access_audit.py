"""Records what a run touches: an audit hook in every Python process of it, and inotify(7) on folders."""

from __future__ import annotations

import ctypes
import json
import os
import struct
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from casa_assets.core.system import cache_dir
from tests.support.library.libraries import ROOT

# Python reads `sitecustomize` at its start; children of the program find it on the same PYTHONPATH. One line per event,
# each by one write to a file opened for appending, so that processes do not mix.
_HOOK = """
import atexit, json, os, sys

LOG = os.open(os.environ["CASA_WATCH"], os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
SEEN = set()
WANTED = ("open", "os.", "shutil.", "socket.", "subprocess.", "urllib.", "tempfile.", "pty.", "ftplib.", "http.")


def watch(event, arguments):
    if not event.startswith(WANTED):
        return
    words = [os.fsdecode(a) if isinstance(a, (bytes, os.PathLike)) else a for a in arguments]
    words = [w if isinstance(w, (str, int)) or w is None else repr(w)[:400] for w in words]
    if event.startswith("os.") and len(words) > 1 and isinstance(words[-1], int) and words[-1] > 2:
        try:  # relative to a folder that is open
            words[0] = os.path.join(os.readlink(f"/proc/self/fd/{words[-1]}"), words[0])
        except (OSError, TypeError):
            pass
    line = json.dumps([event, os.getcwd() if event == "open" else "", *words]) + "\\n"
    if line not in SEEN:
        SEEN.add(line)
        os.write(LOG, line.encode("utf-8", "backslashreplace"))


def leave():
    with open("/proc/self/status", encoding="ascii") as status:
        peak = next(line.split()[1] for line in status if line.startswith("VmHWM"))
    os.write(LOG, (json.dumps(["exit", "", sys.argv[0], int(peak)]) + "\\n").encode())


atexit.register(leave)
sys.addaudithook(watch)
"""
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CHANGES = (
    *("os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.symlink", "os.link", "os.truncate", "os.chmod", "os.chown"),
    *("os.utime", "os.setxattr", "os.removexattr", "os.mkfifo", "os.mknod", "shutil.rmtree", "shutil.move"),
    *("shutil.copyfile", "shutil.copytree", "shutil.chown", "shutil.copymode", "shutil.copystat"),
    *("shutil.make_archive", "shutil.unpack_archive"),
)
# The last two are where native packages look for libraries on other systems when they are imported.
_SYSTEM = (
    *("/usr", "/lib", "/lib64", "/proc", "/sys", "/etc/ld.so.cache", "/etc/localtime", "/etc/mime.types"),
    *("/opt/homebrew/lib", "/run/current-system/sw/lib"),
)
_LOOKS = frozenset({"os.listdir", "os.scandir", "os.walk", "os.getxattr", "os.listxattr"})
_NETWORK = frozenset({"socket.connect", "socket.getaddrinfo", "socket.gethostbyname", "socket.sendto", "socket.bind"})
_STARTS = frozenset({"subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.startfile"})


class Event(NamedTuple):
    """What a process did. `kind`: read, write, network or start. `target`: absolute path, address or command."""

    kind: str
    target: str


class Watch:
    """The audit hook of one or more runs.

    `folder`: empty; gets the hook and its log.
    """

    def __init__(self, folder: Path) -> None:
        (folder / "hook").mkdir(parents=True)
        (folder / "hook" / "sitecustomize.py").write_text(_HOOK, encoding="ascii")
        (folder / "tmp").mkdir()
        self._log = folder / "events.jsonl"
        self.environment: Mapping[str, str] = {
            "PYTHONPATH": str(folder / "hook"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "CASA_WATCH": str(self._log),
            "TMPDIR": str(folder / "tmp"),
        }

    def events(self) -> Iterator[Event]:
        """All that was recorded, each thing once."""
        seen: set[Event] = set()
        for line in self._log.read_text(encoding="utf-8").splitlines():
            for event in _read(json.loads(line)):
                if event not in seen:
                    seen.add(event)
                    yield event

    def peaks(self, program: str) -> list[int]:
        """Most memory, in bytes, of each process of a program that came to its own end."""
        lines = map(json.loads, self._log.read_text(encoding="utf-8").splitlines())
        return [1024 * int(line[3]) for line in lines if line[0] == "exit" and program in str(line[2])]

    def escapes(self, inputs: Sequence[Path], outputs: Sequence[Path]) -> list[Event]:
        """What went beyond reading inputs, writing outputs, the cache, and what Python and the program are made of.

        `inputs`: folders that may be read. `outputs`: folders that may be read and written.
        """
        made_of = [ROOT, Path(sys.prefix), Path(sys.base_prefix), self._log.parent, *map(Path, _SYSTEM)]
        readable = [os.path.realpath(p) for p in (*inputs, *outputs, *made_of, cache_dir())]
        writable = [os.path.realpath(p) for p in (*outputs, self._log.parent / "tmp", cache_dir())]
        return [event for event in self.events() if not _is_allowed(event, readable, writable)]


def _read(line: list[object]) -> Iterator[Event]:
    name, folder, *rest = line
    if name == "open":
        target, mode, flags = (*rest, None, None, 0)[:3]
        if not isinstance(target, str):
            return  # a descriptor that is open already
        writes = isinstance(flags, int) and bool(flags & _WRITING & ~os.O_CLOEXEC)
        writes = writes or bool(set(str(mode or "")) & set("wax+"))
        if not writes and "/" not in target and not (Path(str(folder)) / target).exists():
            return  # relative to a folder that is open: how trees are removed
        yield Event("write" if writes else "read", str(Path(str(folder)) / target))
    elif name in _CHANGES:
        yield from (Event("write", t) for t in rest[: 2 if "rename" in str(name) else 1] if isinstance(t, str))
    elif name in _LOOKS:
        yield Event("read", str(rest[0] if rest[0] is not None else "."))
    elif name in _NETWORK:
        yield Event("network", " ".join(map(str, rest)))
    elif name in _STARTS:
        yield Event("start", " ".join(map(str, rest[:2])))


def _is_allowed(event: Event, readable: Sequence[str], writable: Sequence[str]) -> bool:
    if event.kind == "network":
        return False
    if event.kind == "start":
        return event.target.startswith(sys.executable)
    real = os.path.realpath(event.target)
    if real in ("/dev/null", "/dev/urandom", "/dev/random") or event.target == "/proc/self/oom_score_adj":
        return True
    if event.kind == "read" and real.startswith("/dev/dri"):
        return True  # what draws
    places = writable if event.kind == "write" else readable
    return any(real == place or real.startswith(f"{place}/") for place in places)


_IN_ACCESS, _IN_MODIFY, _IN_ATTRIB, _IN_OPEN, _IN_MOVES, _IN_CREATE, _IN_DELETE = 1, 2, 4, 0x20, 0xC0, 0x100, 0x200
_IN_ISDIR = 0x40000000


@contextmanager
def untouched(*folders: Path) -> Iterator[list[str]]:
    """Names of what is opened, read, changed, made or removed in folders meanwhile, by any process at all.

    Folders that are merely listed are left out: the audit hook tells of ours, and other programs look around on a
    machine. The list is filled when the context ends. Ref: inotify(7).
    """
    libc = ctypes.CDLL(None, use_errno=True)
    handle = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
    assert handle >= 0, os.strerror(ctypes.get_errno())
    mask = _IN_ACCESS | _IN_MODIFY | _IN_ATTRIB | _IN_OPEN | _IN_MOVES | _IN_CREATE | _IN_DELETE
    names: dict[int, str] = {}
    heard: list[str] = []
    try:
        for folder in folders:
            for place in (folder, *(p for p in folder.rglob("*") if p.is_dir())):
                number = libc.inotify_add_watch(handle, os.fsencode(place), mask)
                assert number >= 0, os.strerror(ctypes.get_errno())
                names[number] = str(place)
        yield heard
        try:
            data = os.read(handle, 1 << 20)
        except BlockingIOError:
            data = b""
        at = 0
        while at < len(data):
            number, what, _, length = struct.unpack_from("iIII", data, at)
            name = data[at + 16 : at + 16 + length].rstrip(b"\0").decode("utf-8", "replace")
            at += 16 + length
            if not (what & _IN_ISDIR and what & (_IN_OPEN | _IN_ACCESS)):
                heard.append(f"{names.get(number, '?')}/{name}")
    finally:
        os.close(handle)
