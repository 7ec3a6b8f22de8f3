"""A bag of all that a handover is made of: what the node hears and what it says.

    ros2 launch handover_mesh record.launch.py output:=/tmp/handover

`handover import`, `learn`, `replay` and `evaluate` read such a bag. Interrupt it to end it.
"""

import re

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import FindExecutable, LaunchConfiguration

# Within the namespace, within the node's own, and everybody's.
HEARD = ["skeleton", "skeleton_markers", "robot_skeleton", "object_pose"]
SAID = ["joint_targets", "hand_target", "handover_state", "transition_event"]
GLOBAL = ["/tf", "/tf_static", "/diagnostics"]


def start(context):
    """The recorder."""
    def given(name):
        return LaunchConfiguration(name).perform(context)

    space = "/".join(["", *given("namespace").strip("/").split("/")]).rstrip("/")
    said = SAID + (["markers"] if given("markers") == "true" else [])
    topics = [f"{space}/{name}" for name in HEARD]
    topics += [f"{space}/{given('name')}/{name}" for name in said]
    topics += GLOBAL + given("topics").split()
    # As one expression: how topics are listed differs between distributions, this does not. It
    # also takes topics that appear later.
    wanted = "^(" + "|".join(re.escape(topic) for topic in topics) + ")$"
    command = [FindExecutable(name="ros2"), "bag", "record", "--storage", given("storage"),
               "--regex", wanted]
    if given("output"):
        command += ["--output", given("output")]
    if given("use_sim_time") == "true":
        command += ["--use-sim-time"]
    return [ExecuteProcess(cmd=command, name="record", output="screen")]


def generate_launch_description():
    """What `ros2 launch` runs."""
    return LaunchDescription([
        DeclareLaunchArgument("output", default_value="",
                              description="Folder of the bag, which must not exist yet. Empty: "
                              "rosbag2_ and the date."),
        DeclareLaunchArgument("storage", default_value="mcap", choices=["mcap", "sqlite3"],
                              description="How the bag is stored."),
        DeclareLaunchArgument("namespace", default_value="",
                              description="Namespace of the node that is recorded."),
        DeclareLaunchArgument("name", default_value="handover",
                              description="Name of the node that is recorded."),
        DeclareLaunchArgument("markers", default_value="false", choices=["true", "false"],
                              description="Whether the markers for RViz are recorded: most of the "
                              "bytes, and all in the other topics."),
        DeclareLaunchArgument("topics", default_value="",
                              description="Further topics, full names with spaces between."),
        DeclareLaunchArgument("use_sim_time", default_value="false", choices=["true", "false"],
                              description="Whether messages are stored at the time of /clock."),
        OpaqueFunction(function=start),
    ])
