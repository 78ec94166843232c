"""Images to features, and the start with a camera.

`feature_tracker` follows features through images and `two_view` gives the motion between two of them and the path
up to scale; `camera_time` finds the delay of the camera, and `visual_alignment` the scale and the axes, where the
inner layer starts.
"""
