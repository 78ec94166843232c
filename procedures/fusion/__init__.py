"""Position and attitude: IMU, GNSS and odometry to a trajectory, in two layers.

After the multi-layer visual-inertial-GNSS fusion (Han, Xiao, Huang, Zhang 2022, arXiv:2201.01561).
`fusion_records` come in, `alignment_attempts` finds where to start; `inner` gives an `odometry` by a window of
keyframes, whose IMU samples are one `preintegration` each, and `pose_graph` joins it with GNSS: fixes that lie
far off weigh less (`pose_graph_terms`), and are counted (`pose_graph`); none is rejected. A camera adds `vision`.
"""
