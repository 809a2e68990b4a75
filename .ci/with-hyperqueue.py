"""The recipe for HyperQueue, without its command `hq`, which the package index does not have: a server and a worker of the
package `hyperqueue` run the same commands as two jobs, the second an array.

Usage: with-hyperqueue.py FOLDER SHARDS, with `microslip` on the path and `study.toml` in the folder.
"""

import os
import sys

from hyperqueue import Job
from hyperqueue.cluster import LocalCluster


def main(folder, shards):
    run = "microslip run study.toml --output with-hyperqueue --threads 1 --quiet"
    with LocalCluster() as cluster:
        cluster.start_worker()
        client = cluster.client()
        for commands in (
            [f"{run} --only-atlas"],
            [f"{run} --shard $HQ_TASK_ID/{shards}"] * shards,
        ):
            job = Job()
            for command in commands:
                place = f"{folder}/hyperqueue-%{{JOB_ID}}-%{{TASK_ID}}"
                job.program(
                    ["bash", "-c", command],
                    cwd=folder,
                    stdout=f"{place}.out",
                    stderr=f"{place}.err",
                    env={"PATH": os.environ["PATH"]},
                )
            # raises where a task fails
            client.wait_for_jobs([client.submit(job)])


main(sys.argv[1], int(sys.argv[2]))
