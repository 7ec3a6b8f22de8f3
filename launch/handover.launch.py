"""The node with its parameters, brought to `active` by lifecycle events.

    ros2 launch handover_mesh handover.launch.py model:=/path/to/model.safetensors role:=giver

`--show-args` lists every argument. An argument that is left empty leaves the parameter as the
parameter file has it, and what that does not have is the model's own.
"""

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument, EmitEvent, LogInfo, OpaqueFunction, RegisterEventHandler)
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessStart
from launch.events import matches_action
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from launch_ros.parameter_descriptions import ParameterValue
from lifecycle_msgs.msg import Transition

# Argument → parameter and its type; the description is the argument's.
PARAMETERS = {
    "model": ("node.model", str, "A model file (.safetensors), as `handover learn` writes it."),
    "role": ("node.role", str, "Whose place the model's robot has to take, as the recordings name "
             "them: giver, receiver; A, B."),
    "method": ("node.method", str, "Whether the edges between the people count (mesh), or the "
               "demonstrations alone (none)."),
    "rate": ("node.rate", float, "Ticks, and so targets, a second at least [Hz]."),
    "source": ("node.source", str, "Where the partner is seen: skeleton, tf or markers."),
    "robot_state": ("node.robot_state", str, "How the robot's joints are known at the start: "
                    "reported (on robot_skeleton) or demonstrated."),
    "world_frame": ("node.world_frame", str, "The frame that all is in, the targets too."),
}
# Topic as the node names it → what it carries. Each is an argument: where else to find it.
TOPICS = {
    "skeleton": "the partner's joints, sensor_msgs/MultiDOFJointState",
    "skeleton_markers": "the partner's joints as Azure Kinect's markers",
    "robot_skeleton": "where the robot's own joints are, if it can say",
    "object_pose": "where the object is, geometry_msgs/PoseStamped",
    "~/joint_targets": "targets of the robot's joints, trajectory_msgs/MultiDOFJointTrajectory",
    "~/hand_target": "target of the robot's hand, geometry_msgs/PoseStamped",
}


def argument_of(topic):
    """The argument that remaps a topic: its name without `~/`."""
    return topic.split("/")[-1]


def typed(name, text, kind):
    """An argument's text as its parameter's value: launch coerces only what it substitutes itself."""
    if kind is str:
        # Not as YAML has it: a role may be called 1.
        return ParameterValue(text, value_type=str)
    try:
        return kind(text)
    except ValueError:
        raise RuntimeError(f'Argument "{name}" is "{text}", must be a number.') from None


def start(context):
    """The node, and the events that configure and activate it."""
    def given(name):
        return LaunchConfiguration(name).perform(context)

    chosen = {key: typed(name, given(name), kind)
              for name, (key, kind, _) in PARAMETERS.items() if given(name)}
    chosen["use_sim_time"] = given("use_sim_time") == "true"
    node = LifecycleNode(
        package="handover_mesh", executable="handover_node",
        name=given("name"), namespace=given("namespace"),
        parameters=[*([given("params_file")] if given("params_file") else []), chosen],
        remappings=[(topic, given(argument_of(topic))) for topic in TOPICS
                    if given(argument_of(topic)) != topic],
        ros_arguments=["--log-level", given("log_level")],
        output="screen")

    def change(transition):
        return EmitEvent(event=ChangeState(
            lifecycle_node_matcher=matches_action(node), transition_id=transition))

    wanted = IfCondition(LaunchConfiguration("autostart"))
    return [
        # Before the node: its first event is one of these.
        RegisterEventHandler(
            OnProcessStart(target_action=node,
                           on_start=[change(Transition.TRANSITION_CONFIGURE)]),
            condition=wanted),
        # Of configuring only: whoever deactivates the node wants it inactive.
        RegisterEventHandler(
            OnStateTransition(target_lifecycle_node=node, start_state="configuring",
                              goal_state="inactive",
                              entities=[change(Transition.TRANSITION_ACTIVATE)]),
            condition=wanted),
        RegisterEventHandler(
            OnStateTransition(target_lifecycle_node=node, start_state="configuring",
                              goal_state="unconfigured",
                              entities=[LogInfo(msg="handover: not configured, the node says why; "
                                                "once mended: ros2 lifecycle set NODE configure")]),
            condition=wanted),
        node,
    ]


def generate_launch_description():
    """What `ros2 launch` runs."""
    return LaunchDescription([
        *(DeclareLaunchArgument(
            name, default_value="", description=f"{text} Empty: as in params_file, or by default.")
          for name, (_, _, text) in PARAMETERS.items()),
        DeclareLaunchArgument("params_file", default_value="",
                              description="Parameters over the model's, a YAML file; "
                              "config/handover.yaml of this package explains every one. Empty: the "
                              "model's own."),
        DeclareLaunchArgument("name", default_value="handover",
                              description="Name of the node, and so of its topics and services."),
        DeclareLaunchArgument("namespace", default_value="",
                              description="Namespace of the node: one for each robot."),
        DeclareLaunchArgument("use_sim_time", default_value="false", choices=["true", "false"],
                              description="Whether time is that of /clock."),
        DeclareLaunchArgument("log_level", default_value="info",
                              choices=["debug", "info", "warn", "error", "fatal"],
                              description="From which weight on messages are logged."),
        DeclareLaunchArgument("autostart", default_value="true", choices=["true", "false"],
                              description="Whether the node is configured and activated here; "
                              "otherwise it waits for `ros2 lifecycle set`."),
        *(DeclareLaunchArgument(argument_of(topic), default_value=topic,
                                description=f"Topic: {text}.")
          for topic, text in TOPICS.items()),
        OpaqueFunction(function=start),
    ])
