"""The node with the simulator in place of a sensor and a robot: a recording, or a made-up one.

    ros2 launch handover_mesh replay.launch.py model:=MODEL recording:=clip.csv targets:=echo
    ros2 launch handover_mesh replay.launch.py model:=MODEL targets:=record output:=/tmp/replayed

The simulator starts as soon as the node is active, and with the simulator's end all ends.
"""

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument, EmitEvent, ExecuteProcess, IncludeLaunchDescription, OpaqueFunction,
    RegisterEventHandler)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import FindExecutable, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.event_handlers import OnStateTransition
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

# Argument → the simulator's parameter, its type, default, choices and description.
SIMULATOR = {
    "recording": ("recording", str, "", None,
                  "What is played: a file of any format that `handover` reads. Empty: made up."),
    "seed": ("seed", int, "0", None, "What is made up where no recording is given."),
    "speed": ("speed", float, "1.0", None, "How many times as fast as recorded."),
    "loop": ("loop", bool, "false", ["true", "false"], "Whether it begins anew at its end."),
    "clock": ("clock", bool, "false", ["true", "false"],
              "Whether the simulator's time is published as /clock, and the node keeps it."),
    "tf": ("tf", bool, "false", ["true", "false"],
           "Whether the partner is on /tf as well as on `skeleton`; with source:=tf always."),
}
# Arguments that the node's and the recorder's own launch files explain.
HANDED_ON = {
    "model": "", "role": "", "rate": "", "source": "", "namespace": "", "name": "handover",
    "log_level": "info", "autostart": "true"}
# Where the node can see the partner: the simulator's parameters that send it there are called so.
# What is none of them, the node refuses.
SOURCES = ["skeleton", "tf", "markers"]


def shipped(*path):
    """A file of this package, as installed."""
    return PathJoinSubstitution([FindPackageShare("handover_mesh"), *path])


def typed(name, text, kind):
    """An argument's text as its parameter's value: launch coerces only what it substitutes itself."""
    if kind is str:
        # Not as YAML has it: a recording may be called 1.
        return ParameterValue(text, value_type=str)
    if kind is bool:
        return text == "true"
    try:
        return kind(text)
    except ValueError:
        what = "a whole number" if kind is int else "a number"
        raise RuntimeError(f'Argument "{name}" is "{text}", must be {what}.') from None


def start(context):
    """The node, the simulator and what becomes of the targets."""
    def given(name):
        return LaunchConfiguration(name).perform(context)

    # As arguments of their own: what one file is included with, another one must not see.
    node = {name: given(name) for name in HANDED_ON}
    node["params_file"] = given("params_file")
    node["use_sim_time"] = given("clock")
    chosen = {key: typed(name, given(name), kind)
              for name, (key, kind, _, _, _) in SIMULATOR.items() if given(name)}
    # The node, and the recorder.
    chosen["listeners"] = 2 if given("targets") == "record" else 1
    chosen["exit_at_end"] = True
    if given("role"):
        chosen["role"] = typed("role", given("role"), str)
    if given("source") in SOURCES:
        # There alone: whoever is waited for listens there.
        chosen["skeleton"] = given("source") == "skeleton"
        chosen[given("source")] = True
    files = [given("simulator_params_file")] if given("simulator_params_file") else []
    simulator = Node(
        package="handover_mesh", executable="handover_sim", arguments=["node"],
        name="handover_sim", namespace=given("namespace"), parameters=[*files, chosen],
        ros_arguments=["--log-level", given("log_level")], output="screen")

    actions = [
        RegisterEventHandler(OnStateTransition(
            goal_state="active", entities=[simulator], handle_once=True)),
        RegisterEventHandler(OnProcessExit(
            target_action=simulator,
            on_exit=[EmitEvent(event=Shutdown(reason="the simulator has ended"))])),
    ]
    if given("targets") == "record":
        actions.append(IncludeLaunchDescription(
            PythonLaunchDescriptionSource(shipped("launch", "record.launch.py")),
            launch_arguments={
                "output": given("output"), "storage": given("storage"),
                "namespace": given("namespace"), "name": given("name"),
                "use_sim_time": given("clock"), "markers": "false", "topics": ""}.items()))
    if given("targets") == "echo":
        space = given("namespace").strip("/")
        topic = "/".join(["", *([space] if space else []), given("name"), "joint_targets"])
        actions.append(ExecuteProcess(
            cmd=[FindExecutable(name="ros2"), "topic", "echo", topic], name="echo",
            output="screen"))
    actions.append(IncludeLaunchDescription(
        PythonLaunchDescriptionSource(shipped("launch", "handover.launch.py")),
        launch_arguments=node.items()))
    return actions


def generate_launch_description():
    """What `ros2 launch` runs."""
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=text, choices=choices)
          for name, (_, _, default, choices, text) in SIMULATOR.items()),
        DeclareLaunchArgument("simulator_params_file", default_value="",
                              description="Further parameters of the simulator, a YAML file: the "
                              "sensor's faults are under `sensor`."),
        DeclareLaunchArgument("targets", default_value="none", choices=["none", "echo", "record"],
                              description="What becomes of the targets."),
        DeclareLaunchArgument("output", default_value="",
                              description="Folder of the bag, with targets:=record. Empty: "
                              "rosbag2_ and the date."),
        DeclareLaunchArgument("storage", default_value="mcap", choices=["mcap", "sqlite3"],
                              description="How the bag is stored, with targets:=record."),
        DeclareLaunchArgument("params_file", default_value="",
                              description="As `params_file` of handover.launch.py."),
        *(DeclareLaunchArgument(name, default_value=default,
                                description=f"As `{name}` of handover.launch.py.")
          for name, default in HANDED_ON.items()),
        OpaqueFunction(function=start),
    ])
