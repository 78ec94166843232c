"""Where and which way: IMU, GNSS and odometry to a trajectory in two layers.

After the multi-layer visual-inertial-GNSS fusion (Han, Xiao, Huang, Zhang 2022, arXiv:2201.01561); what its text
leaves open is chosen here, and said where.
"""
