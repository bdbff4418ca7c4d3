"""A long sweep on a local cluster of dask.distributed with two workers: time, and memory of all processes.

Usage: python benchmarks/cluster_sweep.py [rows]
"""

from __future__ import annotations

import resource
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import distributed
import numpy as np

import governor_mechanism as gm

N_ROWS = 100_000
N_WORKERS = 2
N_ARMS = 100
"""Number of lengths of the arms; each has as many masses of the sleeve as the rows need."""


def main() -> None:
    """Run the sweep and print its table."""
    n_rows = int(sys.argv[1]) if len(sys.argv) > 1 else N_ROWS
    scene = gm.load("porter")
    scene = replace(scene, run=replace(scene.run, duration=0.1))
    vary = {
        "dimensions.arm": np.linspace(0.29, 0.35, N_ARMS).tolist(),
        "dimensions.sleeve_mass": np.linspace(10.0, 20.0, n_rows // N_ARMS).tolist(),
    }
    sizes: dict[int, float] = {}
    start_cluster: Any = distributed.LocalCluster
    connect: Any = distributed.Client

    def note_size(n_done: int, n_all: int) -> None:
        for share in (10, 50, 100):
            if n_done >= share * n_all / 100:
                sizes.setdefault(share, current_size())

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of dask, about ports
        cluster = start_cluster(n_workers=N_WORKERS, threads_per_worker=1, dashboard_address=None)
    with cluster, connect(cluster) as client:
        started = time.perf_counter()
        found = gm.sweep(scene, vary, ["final arm_angle"], engine="reduced", certify=False, cluster=client, progress=note_size)
        seconds = time.perf_counter() - started
        largest = max(client.run(largest_size).values())
    print(f"| {len(found.rows):,} Porter governors, 0.1 s each, a cluster of {N_WORKERS} workers on this computer | |\n|---|---|")
    print(f"| outcomes | {', '.join(f'{count:,} {outcome}' for outcome, count in found.outcomes.items())} |")
    print(f"| time, s | {seconds:.0f} |")
    print(f"| ms a row | {1e3 * seconds / len(found.rows):.2f} |")
    own = ", ".join(f"{one:.0f}" for one in sizes.values())
    print(f"| memory of the asking process, with the scheduler, after 10, 50 and 100 %, MB | {own} |")
    print(f"| largest memory of a worker, MB | {largest:.0f} |")


def current_size() -> float:
    """Return the present memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 2**20


def largest_size() -> float:
    """Return the largest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
