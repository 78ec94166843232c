"""The outer layer: odometry steps and GNSS fixes in one graph of four degrees of freedom."""
