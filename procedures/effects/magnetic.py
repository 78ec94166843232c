"""Magnetic sensitivity of the gyroscopes: ``M B``, by the Faraday effect in fibre that is not quite polarising.

Needs the site's field. Its part along the vertical is one with g-sensitivity, and heading alone separates the two
apart. Plausible: 0.1 deg/h/uT (10 deg/h per gauss), of a coil without shield.
"""

from procedures.effects.effect import MATRIX, Columns, Effect, matrix_columns
from procedures.units import DEG_H_PER_DEG_S

EFFECT = Effect(
    name="gyroscope.magnetic",
    unit="deg/h/uT",
    physics="M B",
    source="IEEE Std 952, magnetic sensitivity; K. Hotate, K. Tabe, Appl. Opt. 25 (1986) 1086",
    plausible=0.1,
    columns=lambda seen: [Columns(MATRIX, gyro=matrix_columns(seen.magnetic) / DEG_H_PER_DEG_S)],
    separate_by="the same positions with the magnetic field turned or shielded",
)
