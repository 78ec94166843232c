"""Roll and pitch online: the mixing law, which is a complementary filter, and the Kalman filter, the default.

The mixing law and its velocity aids are those of You, Lee, *An accelerometer-aided mixing algorithm for strapdown
attitude (roll, pitch)*. Body axes are forward-right-down, the level frame north-east-down (`forward_right_down`);
attitude is carried as the *down vector*, the unit vector of gravity in body axes, which has no singularity.
Physics and measured figures: ``docs/explanation/attitude.md``.
"""
