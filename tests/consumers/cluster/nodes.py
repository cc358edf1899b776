"""Keep a Ray cluster of some machines, all on this one, and change it as the lines of the input say.

    python nodes.py '[{}, {"TMPDIR": "/full"}]'      two machines, the second with an environment of its own

Prints the address, then obeys: `kill` ends the last machine at once, as a power cut; `add` brings another one like the
last of the list. Each machine has one processor. It ends when its input is closed.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from ray.cluster_utils import Cluster

MEMORY_BYTES = 10_000_000_000
STORE_BYTES = 100_000_000


@contextmanager
def with_variables(more: dict[str, str]) -> Iterator[None]:
    """Variables of the environment besides ours; Ray's own argument for them cannot change LD_PRELOAD."""
    before = dict(os.environ)
    os.environ.update(more)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


if __name__ == "__main__":
    environments = json.loads(sys.argv[1])
    settings = {"num_cpus": 1, "object_store_memory": STORE_BYTES, "resources": {}, "memory": MEMORY_BYTES}
    with with_variables(environments[0]):
        cluster = Cluster(initialize_head=True, head_node_args={**settings, "include_dashboard": False})
    nodes = []
    for one in environments[1:]:
        with with_variables(one):
            nodes.append(cluster.add_node(**settings))
    print(cluster.address, flush=True)
    for line in sys.stdin:
        if line.strip() == "kill":
            cluster.remove_node(nodes.pop(), allow_graceful=False)
        elif line.strip() == "add":
            with with_variables(environments[-1]):
                nodes.append(cluster.add_node(**settings))
        print("done", flush=True)
    cluster.shutdown()
