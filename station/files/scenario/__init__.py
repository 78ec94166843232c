"""A whole simulated bench from one file: IMU, receiver, the operator's hands, faults; docs/how-to/testing.md."""

from station.files.scenario.scenario_reading import Scenario, read_scenario
from station.files.scenario.scenario_serving import serve_scenario

__all__ = ["Scenario", "read_scenario", "serve_scenario"]
