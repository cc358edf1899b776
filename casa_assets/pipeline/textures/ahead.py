"""Paint the pictures of a kitchen in threads, while parts of it that need none of them, or have theirs, are built.

Painting is work on large arrays, during which Python lets other threads run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar

from casa_assets.model.registry.finish import Finish
from casa_assets.pipeline.process_name import is_worker

# Paints one finish. What it raises is raised where the finish is asked for.
Painting = Callable[[], Finish]
# A painting takes some 100 MB meanwhile.
THREADS = 2


class _Ahead:
    """Paintings that are begun when the first one of them is missing."""

    def __init__(self, all_missing: Callable[[], Mapping[str, Painting]]) -> None:
        self._all_missing = all_missing
        self._begun: dict[str, Future[Finish]] | None = None
        self._pool: ThreadPoolExecutor | None = None

    def painted(self, key: str, painting: Painting) -> Finish:
        """The finish of that key, once it is there."""
        if self._begun is None:
            self._pool = ThreadPoolExecutor(THREADS)
            self._begun = {other: self._pool.submit(each) for other, each in self._all_missing().items()}
        begun = self._begun.get(key)
        return painting() if begun is None else begun.result()

    def close(self) -> None:
        """Wait for what is being painted; what was not begun stays so."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)


_CURRENT: ContextVar[_Ahead | None] = ContextVar("paintings", default=None)


@contextmanager
def painting_ahead(all_missing: Callable[[], Mapping[str, Painting]]) -> Iterator[None]:
    """Within it, the first finish that has to be painted has all others painted beside it.

    Not in a worker process: there the other cores have workers of their own.

    Args:
        all_missing: what is going to be asked for and is not in the cache, by key, first what is needed first.
    """
    if is_worker():
        yield
        return
    ahead = _Ahead(all_missing)
    token = _CURRENT.set(ahead)
    try:
        yield
    finally:
        _CURRENT.reset(token)
        ahead.close()


def painted(key: str, painting: Painting) -> Finish:
    """A finish, painted in this thread, or by those that have begun with it."""
    ahead = _CURRENT.get()
    return painting() if ahead is None else ahead.painted(key, painting)
