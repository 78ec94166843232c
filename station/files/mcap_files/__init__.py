"""A step's recording as MCAP: counts and the bytes as read, open to Foxglove and PlotJuggler."""

from station.files.mcap_files.messages import StepContents
from station.files.mcap_files.reader import read_step
from station.files.mcap_files.schemas import BY_OUTPUT, COUNTS, RATES
from station.files.mcap_files.step_table import read_table
from station.files.mcap_files.writer import StepWriter

__all__ = ["BY_OUTPUT", "COUNTS", "RATES", "StepContents", "StepWriter", "read_step", "read_table"]
