"""Keep a Ray cluster of some machines, all on this one, and add, kill and end them as the lines of the input say.

    python ray_nodes.py 2        prints the address, then obeys: `kill` ends the last machine at once, as a power cut

Each machine has one processor. It ends when its input is closed.
"""

from __future__ import annotations

import sys

from ray.cluster_utils import Cluster

MEMORY_BYTES = 10_000_000_000
STORE_BYTES = 100_000_000

if __name__ == "__main__":
    settings = {"num_cpus": 1, "object_store_memory": STORE_BYTES, "resources": {}, "memory": MEMORY_BYTES}
    cluster = Cluster(initialize_head=True, head_node_args={**settings, "include_dashboard": False})
    nodes = [cluster.add_node(**settings) for _ in range(int(sys.argv[1]) - 1)]
    print(cluster.address, flush=True)
    for line in sys.stdin:
        if line.strip() == "kill":
            cluster.remove_node(nodes.pop(), allow_graceful=False)
        print("done", flush=True)
    cluster.shutdown()
