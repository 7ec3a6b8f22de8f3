"""Stand-in for ROS 2's `launch_ros`, as strict as that for `launch`."""
