"""``station.CalibratedSample`` of a live sample: every field, and a truth value for each flag."""

from typing import Any

from station.files.mcap_files.calibrated_sample import FIELDS, SAMPLE, sample_message
from station.files.mcap_files.schemas import built
from station.sending.quality import Quality

FLAGS = tuple((flag, str(flag.name).lower()) for flag in Quality)
SCHEMA, _MESSAGES = built(sample_message(FIELDS, [name for _, name in FLAGS]))
CalibratedSample: Any = _MESSAGES[SAMPLE]
