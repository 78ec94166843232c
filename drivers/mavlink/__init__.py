"""GNSS over MAVLink: bytes of any port to GNSS records, and what is requested from them.

`session` opens a link and asks for messages; `frames` finds and checks them; `gnss_fixes` makes GNSS records of
them. `imu_out` sends the other way: an IMU's attitude and rates.
"""
