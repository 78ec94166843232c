"""Pure numerics of the station: arrays in, frozen results out.

Conventions, stated once
------------------------
- Inside: SI and radians. Exceptions carry a suffix: ``_deg``, ``_g``, ``_dph`` (deg/h).
- ``n`` is local level East-North-Up, ``b`` the cube's axes (in `fusion` and `attitude` the IMU's or the
  vehicle's), ``s`` the IMU's axes in the cube, ``i`` inertial; ``C_nb`` takes b to n. At rest
  ``f_n = (0, 0, +g)``. ``_raw`` is a triad's own axes before calibration.
- Sensor model ``N = k * (E u + D)`` (Yao, Hu, He 2018, eq. 1, 2): N count rate, u specific force [g]
  or angular rate [deg/s], E rows = sensor, columns = axis of the IMU, rows of unit length.
- g is standard gravity 9.80665 m/s2 wherever it is a unit.
"""
