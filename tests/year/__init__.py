"""A simulated year a night: whole guided campaigns in one process and in device time, with whatever may go wrong.

`python -m tests.year --seed S --campaigns N`; docs/contributing/station-tests.md says how to read its output.
"""
