"""Conversion of units, and nothing else. ``A_PER_B`` is how many A are in one B: a value in B times it is in A.

RAD_S is rad/s, DEG_H deg/h.
"""

from math import pi

STANDARD_GRAVITY = 9.80665  # m/s2 per g, exact (CGPM 1901)
M_PER_FT = 0.3048  # exact
UG_PER_G = PPM_PER_ONE = 1e6
RAD_PER_URAD = 1e-6

RAD_PER_DEG = pi / 180
ARCSEC_PER_DEG = 3600.0
RAD_PER_ARCSEC = RAD_PER_DEG / ARCSEC_PER_DEG
ARCSEC_PER_RAD = 1 / RAD_PER_ARCSEC

S_PER_H = 3600.0
S_PER_MIN = 60.0
M_S_PER_KM_H = 1000 / S_PER_H
M_S_PER_MPH = 0.44704  # exact
M_S_PER_KNOT = 1852 / S_PER_H  # exact
DEG_H_PER_DEG_S = S_PER_H
RAD_S_PER_DEG_H = RAD_PER_DEG / DEG_H_PER_DEG_S
DEG_H_PER_RAD_S = 1 / RAD_S_PER_DEG_H
