"""Position and attitude by IMU, GNSS, camera and wheel.

A folder goes through `locate_folder`, which takes `imu_source`, `camera_source` or odometry, then `outer_layer`
(the pose graph). A live run goes through `live_locator`, which uses `live_alignment`, `live_fixes`, `live_camera`;
the monitor talks to it by `monitor_interface` and shows a `location`. `folder_from_recording` makes a folder.
"""
