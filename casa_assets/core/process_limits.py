"""Limit the resources of this process, such as a child that runs a library which may hang or exhaust memory."""

from __future__ import annotations

import resource


def lower_limit(kind: int, soft: int, hard: int) -> None:
    """Set a resource limit of this process; a limit that is already lower is kept.

    Args:
        kind: such as `resource.RLIMIT_CPU` (seconds) or `resource.RLIMIT_AS` (bytes).
        soft: limit at which the system refuses more, or sends a signal.
        hard: limit up to which the process may raise the soft one again.
    """
    stands = resource.getrlimit(kind)[1]
    ceiling = hard if stands == resource.RLIM_INFINITY else min(hard, stands)
    resource.setrlimit(kind, (min(soft, ceiling), ceiling))
