"""Limit what this process may use, such as a child that runs a library which may hang or eat memory."""

from __future__ import annotations

import resource


def lower_limit(kind: int, soft: int, hard: int) -> None:
    """Set a limit of this process; one that already stands lower stays.

    Args:
        kind: such as `resource.RLIMIT_CPU` (seconds) or `resource.RLIMIT_AS` (bytes). soft: from which on the system
            says no, or sends a signal. hard: to which the process may raise it again.
    """
    stands = resource.getrlimit(kind)[1]
    ceiling = hard if stands == resource.RLIM_INFINITY else min(hard, stands)
    resource.setrlimit(kind, (min(soft, ceiling), ceiling))
