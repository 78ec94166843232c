"""A calibration applied to a recording, from any source into any format.

`open_source` gives a `source` of samples (`log_source`, `recording_source`), `checked_samples` checks times and
numbers, `applying` writes the file in the units, frame and columns that are asked for.
"""
