"""A scenario: a whole simulated bench in one file, IMU, receiver, the operator's hands and faults; docs/testing.md."""

from station.scenario.reading import Scenario, read_scenario
from station.scenario.serving import serve_scenario

__all__ = ["Scenario", "read_scenario", "serve_scenario"]
