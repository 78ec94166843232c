"""Roll and pitch of a live IMU.

`monitor_command` opens source, calibration and outputs; `monitor` is the engine, run by `monitor_thread`.
`auxiliary_inputs` merges receiver, camera and wheel; `locator_thread` locates; `recording` writes the run; a
`view` is what screens and `text_lines` show.
"""
