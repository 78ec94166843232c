"""A step's recording as MCAP: counts and the bytes as read, open to Foxglove and PlotJuggler.

`schemas` declares the messages; `writer` writes a step; `reader` checks a file's `records` and turns its
`messages` into columns; `gnss_file` holds a receiver's records.
"""

from station.files.mcap_files.messages import StepContents
from station.files.mcap_files.reader import read_step, read_table
from station.files.mcap_files.schemas import BY_OUTPUT, COUNTS, RATES
from station.files.mcap_files.writer import StepWriter

__all__ = ["BY_OUTPUT", "COUNTS", "RATES", "StepContents", "StepWriter", "read_step", "read_table"]
