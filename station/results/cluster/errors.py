"""What can be wrong with those who do the work.

StationError
├── NoCluster          the extra is not installed, or nobody answers at the scheduler's address
└── ClusterLost        a cluster that answered was lost during the run
"""

from station.errors import StationError


class NoCluster(StationError, ConnectionError):
    """There is no cluster to work on."""

    def __init__(self, found: str, expected: str, remedy: str) -> None:
        self.found, self.expected = found, expected
        super().__init__(f"found {found}, expected {expected}; {remedy}")


class ClusterLost(StationError, ConnectionError):
    """The cluster went away; what had arrived is kept."""

    def __init__(self, found: str) -> None:
        self.found = found
        super().__init__(
            f"found {found}, expected a cluster to the end; start it again and repeat the command: it goes on"
        )
