"""Work side by side: in this process, in processes of this machine, or on a cluster, all behind the interface of
`concurrent.futures`.

    with open_executor(jobs=4) as executor:
        for item, future in as_finished(executor, function, items):
            ...

Only functions of modules and plain values are handed over, never compiled functions. A process computes one thing at
a time: a compiled CasADi function must not be called from two threads.
"""

from __future__ import annotations

from .side import ClusterUnavailable, InProcess, Side, WorkerLost, WorkFailed, as_finished

__all__ = ["ClusterUnavailable", "Side", "WorkFailed", "WorkerLost", "as_finished", "open_executor"]


def open_executor(jobs: int = 1, cluster: str | None = None) -> Side:
    """An executor for a `with` statement: on the cluster at `cluster` (tcp://HOST:PORT), else in `jobs` processes,
    or in this process where `jobs` is 1. Leaving the statement by an error, such as Ctrl-C, drops all work.

    Raises ClusterUnavailable."""
    if cluster is not None:
        from .cluster import Cluster

        return Cluster(cluster)
    if jobs == 1:
        return InProcess()
    from .processes import Processes

    return Processes(jobs)
