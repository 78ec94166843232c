"""What went wrong in a recording and is no column of a model: it is corrected before causes are inferred.

`checks` runs all: the device's clock, wrong positions and directions (`wrong_positions`, `dwell_headings`),
disturbances of dwells and soaks with their size (`disturbances`, `disturbed_soaks`, `vibration`), and channels
that are clipped, frozen or noisier from a moment on (`channel_faults`).
"""
