"""What a cube's machining tolerances do to an accelerometer calibration, and what tolerances an accuracy needs.

After Yao, Hu and He 2018, tables 2 and 3, equations (13)-(20), and beyond it: any tilt of any face, quadratic
coefficients, the joint solve. ``items`` the drawing's items and how they stack up, ``estimators`` the exact error
of every estimator on given tilts, ``bound`` the worst case, ``draw`` the distribution, ``allowance`` the way back
from an accuracy to tolerances, ``remedy`` what else would help.
"""
