"""From bytes to accepted steps on the disk.

`sample_stream` decodes chunks and sees every gap; `sample_buffer` keeps the last stretch; `sample_times` gives
UTC; `accepted_step_writer` writes and hashes a step of a campaign, `plain_recording` anything else.
"""
