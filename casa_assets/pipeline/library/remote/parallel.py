"""Do many requests of a store at once, in threads: most of their time is waiting."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")
THREADS = 16


def in_threads(call: Callable[[T], R], items: Iterable[T], abandon: Callable[[], None]) -> Iterator[R]:
    """Yield what the call gives for each item, as they finish; an exception of a call ends all.

    No more items are taken than are worked on, so what they hold does not add up.

    Args:
        abandon: called where an exception ends it, before the calls that are under way are waited for.
    """
    left = iter(items)
    open_: set[Future[R]] = set()
    with ThreadPoolExecutor(THREADS, thread_name_prefix="store") as threads:
        try:
            while True:
                for item in islice(left, THREADS - len(open_)):
                    open_.add(threads.submit(call, item))
                if not open_:
                    return
                done, open_ = wait(open_, return_when=FIRST_COMPLETED)
                for future in done:
                    yield future.result()
        except BaseException:
            abandon()
            for future in open_:
                future.cancel()
            raise
