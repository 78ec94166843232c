"""A calibration applied to a recording, from any source into any format.

`open_source` gives a `source` of samples (`log_source`, `recording_source`), `checked_samples` checks times and
numbers, `output_request` says units, frame and columns, `applying` writes the file.
"""
