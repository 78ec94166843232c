"""Where and which way: IMU, GNSS and odometry to a trajectory in two layers.

After the multi-layer visual-inertial-GNSS fusion (P3); what its text leaves open is chosen here, and said where.
"""
