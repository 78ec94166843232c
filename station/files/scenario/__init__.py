"""A whole simulated bench from one file: IMU, receiver, the operator's hands, faults; docs/testing.md."""

from station.files.scenario.reading import Scenario, read_scenario
from station.files.scenario.serving import serve_scenario

__all__ = ["Scenario", "read_scenario", "serve_scenario"]
