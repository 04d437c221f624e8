"""A Ray cluster of two nodes with a core each, on the loopback address: two machines, as far as Ray knows.

Prints the address of the cluster and the one for Ray's client, in a line each. A line on standard input ends the second
node, as if its machine had died; the end of the input ends all.
"""

import os
import sys
import tempfile

from jaxwalk.experiments.on_ray import ALONE

os.environ.update(ALONE)  # Ray reads it when it is imported

from ray._common.network_utils import find_free_port
from ray.cluster_utils import Cluster

with tempfile.TemporaryDirectory(prefix="two-", ignore_cleanup_errors=True) as folder:
    client = find_free_port()
    node = {"num_cpus": 1, "object_store_memory": 100_000_000, "include_dashboard": False}
    head = {**node, "temp_dir": folder, "ray_client_server_port": client}
    cluster = Cluster(initialize_head=True, head_node_args=head)
    second = cluster.add_node(**{**node, "include_dashboard": None, "temp_dir": folder})
    cluster.wait_for_nodes()
    print(cluster.address, f"ray://127.0.0.1:{client}", sep="\n", flush=True)
    if sys.stdin.readline():
        cluster.remove_node(second, allow_graceful=False)
        print("one node", flush=True)
    sys.stdin.read()
    cluster.shutdown()
