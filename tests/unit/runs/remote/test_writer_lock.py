"""One writer at a time on a store, whatever the clocks of machines say."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import pytest

from casa_assets.errors import OutputError
from casa_assets.library import remote_folder
from casa_assets.library.remote_folder import WRITERS, RemoteFolder, Writer, WriterLock, hold
from tests.support.library.faulty_stores import ROOT, FaultyStore

SILENCE_S = 0.4


def folder_on(store: FaultyStore) -> RemoteFolder:
    return RemoteFolder(store, ROOT, "memory://library", 1.0)


def quick(folder: RemoteFolder) -> WriterLock:
    return WriterLock(folder, beat_s=0.05, silence_s=SILENCE_S)


def leave(store: FaultyStore, **words: object) -> None:
    writer = Writer.own().replace(**{"boot": "another", "host": "node7", **words})
    store.pipe_file(f"{ROOT}/{WRITERS}/0000.json", writer.model_dump_json().encode())


def test_a_second_writer_is_refused_and_the_first_goes_on() -> None:
    store = FaultyStore()
    with hold(folder_on(store)) as first:
        with pytest.raises(OutputError, match=r"process \d+ on .* is writing to this library"), hold(folder_on(store)):
            pass
        first.check()
    with hold(folder_on(store)):
        pass
    assert store.content == {}


def test_two_that_begin_at_once_do_not_both_write() -> None:
    inside, start, seen = threading.Semaphore(1), threading.Barrier(2), list[bool]()

    def write(store: FaultyStore) -> None:
        start.wait()
        with suppress(OutputError), hold(folder_on(store)):
            seen.append(inside.acquire(blocking=False))
            time.sleep(0.01)
            inside.release()

    for _ in range(20):
        store = FaultyStore()
        store.pause_s = 0.0005
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(write, [store, store]))
    assert False not in seen


def test_a_run_of_this_machine_that_was_killed_is_not_waited_for() -> None:
    store, told = FaultyStore(), list[str]()
    leave(store, boot=Writer.own().boot, started=1)
    with hold(folder_on(store), told.append):
        assert len(store.content) == 1
    assert told == []


def test_a_silent_run_of_another_machine_is_waited_for_by_the_own_clock_and_what_is_no_writer_too() -> None:
    store, told = FaultyStore(), list[str]()
    leave(store, beat=10**9)
    folder = folder_on(store)
    for _ in range(2):
        with hold(folder, told.append, quick(folder)):
            assert f"{WRITERS}/0000.json" not in store.content
        store.pipe_file(f"{ROOT}/{WRITERS}/0000.json", b"{")
    assert "node7" in told[0]


def test_a_run_of_another_machine_that_goes_on_is_not_disturbed() -> None:
    store, ended = FaultyStore(), threading.Event()

    def beat() -> None:
        number = 0
        while not ended.wait(0.02):
            number += 1
            leave(store, beat=number)

    leave(store)
    thread = threading.Thread(target=beat)
    thread.start()
    folder = folder_on(store)
    with pytest.raises(OutputError, match="on node7 is writing to this library"), hold(folder, lock=quick(folder)):
        pass
    ended.set()
    thread.join()
    assert list(store.content) == [f"{WRITERS}/0000.json"]


def test_a_run_that_stood_still_finds_that_it_was_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    store = FaultyStore()
    folder = folder_on(store)
    lock = WriterLock(folder, beat_s=1000.0, silence_s=SILENCE_S)
    with hold(folder, lock=lock):
        lock.check()
        for path in store.content:
            store.rm_file(f"{ROOT}/{path}")
        clock = remote_folder._clock
        monkeypatch.setattr(remote_folder, "_clock", lambda: clock() + SILENCE_S)
        with pytest.raises(OutputError, match="another run has taken the library over"):
            lock.check()
    assert store.content == {}


def test_processes_are_told_by_when_they_began() -> None:
    own = Writer.own()
    assert own.is_running is True
    assert own.replace(started=own.started - 1).is_running is False
    assert own.replace(boot="another").is_running is None
    assert own.replace(space="pid:[1]").is_running is None
