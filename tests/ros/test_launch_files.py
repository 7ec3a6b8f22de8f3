"""Every launch file, executed with its defaults and with every argument.

Stand-ins of `launch` and `launch_ros` show what would be started. Where the real ones are, the same
files are also executed with those.
"""

import importlib
import os
import pathlib
import re
import subprocess
import sys

import pytest
import yaml

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parents[1]
FILES = ["handover", "record", "replay"]
CONFIGURE, ACTIVATE = 1, 3


def ours(name):
    return name.split(".")[0] in ("launch", "launch_ros")


@pytest.fixture
def stubs(monkeypatch):
    """The stand-ins, for this test alone."""
    theirs = {name: module for name, module in sys.modules.items() if ours(name)}
    for name in theirs:
        del sys.modules[name]
    monkeypatch.syspath_prepend(str(HERE / "stubs"))
    monkeypatch.setenv("HANDOVER_SHARE", str(ROOT))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield importlib.import_module("launch")
    for name in [name for name in sys.modules if ours(name)]:
        del sys.modules[name]
    sys.modules.update(theirs)


@pytest.fixture
def execute(stubs):
    """Executes a file with arguments: everything that was executed, in order."""
    sources = importlib.import_module("launch.launch_description_sources")

    def execute(name, /, **arguments):
        context = stubs.LaunchContext(arguments)
        path = str(ROOT / "launch" / f"{name}.launch.py")
        description = sources.PythonLaunchDescriptionSource(path).load(context)
        unknown = set(arguments) - {one.name for one in declared(description)}
        assert not unknown, f"{name} has no {unknown}"
        stubs.run([description], context)
        return context.executed
    return execute


def declared(description):
    return [entity for entity in description.entities if hasattr(entity, "default_value")]


def of(executed, kind):
    return [one for one in executed if type(one).__name__ == kind]


def handlers(executed, kind):
    found = [one.event_handler for one in of(executed, "RegisterEventHandler")]
    return [one for one in found if type(one).__name__ == kind]


@pytest.mark.parametrize("name", FILES)
def test_every_argument_is_described_and_has_a_default(execute, name):
    own = [one for one in of(execute(name), "DeclareLaunchArgument")]
    assert len(own) > 5
    for argument in own:
        assert argument.description and argument.description.endswith(".")
        assert argument.default_value is not None
    with pytest.raises(AssertionError, match="has no"):
        execute(name, rolle="giver")


@pytest.mark.parametrize(("name", "argument"), [
    ("handover", "autostart"), ("handover", "use_sim_time"), ("handover", "log_level"),
    ("record", "storage"), ("record", "markers"), ("record", "use_sim_time"),
    ("replay", "loop"), ("replay", "clock"), ("replay", "tf"), ("replay", "targets"),
    ("replay", "storage")])
def test_a_wrong_choice_is_refused_and_every_right_one_taken(execute, name, argument):
    choices = next(one.choices for one in of(execute(name), "DeclareLaunchArgument")
                   if one.name == argument and one.choices)
    for choice in choices:
        execute(name, **{argument: choice})
    with pytest.raises(RuntimeError, match=argument):
        execute(name, **{argument: "perhaps"})


def test_the_node_by_default_has_the_models_parameters(execute):
    executed = execute("handover")
    node, = of(executed, "LifecycleNode")
    assert (node.package, node.executable) == ("handover_mesh", "handover_node")
    assert (node.node_name, node.namespace) == ("handover", "")
    assert node.files == []
    assert node.values == {"use_sim_time": False}
    assert node.remappings == []
    assert node.ros_arguments == ["--log-level", "info"]


def test_the_node_is_configured_and_then_activated(execute):
    executed = execute("handover")
    node, = of(executed, "LifecycleNode")
    # Registered before the node is there: no event of it is missed.
    assert executed.index(node) > max(map(executed.index, of(executed, "RegisterEventHandler")))
    started, = handlers(executed, "OnProcessStart")
    assert started.target_action is node
    change, = started.entities
    assert change.event.transition_id == CONFIGURE
    assert change.event.lifecycle_node_matcher(node)
    configured, failed = handlers(executed, "OnStateTransition")
    assert configured.target is node and failed.target is node
    assert (configured.start_state, configured.goal_state) == ("configuring", "inactive")
    change, = configured.entities
    assert change.event.transition_id == ACTIVATE
    assert change.event.lifecycle_node_matcher(node)
    assert (failed.start_state, failed.goal_state) == ("configuring", "unconfigured")
    assert "not configured" in failed.entities[0].msg


def test_without_autostart_nothing_is_changed(execute):
    executed = execute("handover", autostart="false")
    assert len(of(executed, "LifecycleNode")) == 1
    assert not of(executed, "RegisterEventHandler")


def test_the_nodes_arguments_reach_it(execute):
    executed = execute(
        "handover", model="/m.safetensors", role="1", method="none", rate="60", world_frame="map",
        source="tf", robot_state="demonstrated",
        params_file="/p.yaml", name="left", namespace="/robots/two", use_sim_time="true",
        log_level="debug", skeleton="/camera/skeleton", skeleton_markers="/camera/markers",
        robot_skeleton="own", object_pose="/cup", joint_targets="/targets", hand_target="/hand")
    node, = of(executed, "LifecycleNode")
    assert (node.node_name, node.namespace) == ("left", "/robots/two")
    assert node.files == ["/p.yaml"]
    # The role keeps being text; the rate is a float, which a declared double needs.
    assert node.values == {
        "node.model": "/m.safetensors", "node.role": "1", "node.method": "none", "node.rate": 60.0,
        "node.source": "tf", "node.robot_state": "demonstrated", "node.world_frame": "map",
        "use_sim_time": True}
    shipped = yaml.safe_load((ROOT / "config" / "handover.yaml").read_text())
    section = shipped["/**"]["ros__parameters"]["node"]
    assert {f"node.{key}" for key in section} >= set(node.values) - {"use_sim_time"}
    assert isinstance(node.values["node.rate"], float)
    assert node.remappings == [
        ("skeleton", "/camera/skeleton"), ("skeleton_markers", "/camera/markers"),
        ("robot_skeleton", "own"), ("object_pose", "/cup"),
        ("~/joint_targets", "/targets"), ("~/hand_target", "/hand")]
    assert node.ros_arguments == ["--log-level", "debug"]


def recorded(words):
    """The topics among candidates that a recorder takes."""
    wanted = re.compile(words[words.index("--regex") + 1])
    names = ["/skeleton", "/ns/skeleton", "/ns/skeleton_markers", "/ns/robot_skeleton",
             "/ns/object_pose", "/ns/handover/joint_targets", "/ns/handover/hand_target",
             "/ns/handover/handover_state", "/ns/handover/transition_event",
             "/ns/handover/markers", "/handover/joint_targets", "/tf", "/tf_static",
             "/diagnostics", "/rosout", "/extra", "/ns/left/joint_targets", "/nsx/skeleton"]
    return {name for name in names if wanted.search(name)}


def test_a_bag_of_what_is_needed(execute):
    process, = of(execute("record"), "ExecuteProcess")
    assert process.words[:5] == ["/bin/ros2", "bag", "record", "--storage", "mcap"]
    assert "--output" not in process.words and "--use-sim-time" not in process.words
    assert recorded(process.words) == {
        "/skeleton", "/handover/joint_targets", "/tf", "/tf_static", "/diagnostics"}


@pytest.mark.parametrize("namespace", ["ns", "/ns", "/ns/"])
def test_a_bag_of_a_namespace(execute, namespace):
    process, = of(execute("record", namespace=namespace, markers="true", topics="/extra /more",
                          output="/tmp/bag", storage="sqlite3", use_sim_time="true"),
                  "ExecuteProcess")
    assert process.words[3:5] == ["--storage", "sqlite3"]
    assert process.words[-3:] == ["--output", "/tmp/bag", "--use-sim-time"]
    assert recorded(process.words) == {
        "/ns/skeleton", "/ns/skeleton_markers", "/ns/robot_skeleton", "/ns/object_pose",
        "/ns/handover/joint_targets", "/ns/handover/hand_target", "/ns/handover/handover_state",
        "/ns/handover/transition_event", "/ns/handover/markers", "/tf", "/tf_static",
        "/diagnostics", "/extra"}


def simulator_of(executed):
    """The handler that starts the simulator, and the simulator."""
    starts, = (one for one in handlers(executed, "OnStateTransition")
               if one.goal_state == "active")
    return starts, starts.entities[0]


def test_the_simulator_starts_with_an_active_node_and_ends_all(execute, stubs):
    executed = execute("replay")
    node, = of(executed, "LifecycleNode")
    assert not of(executed, "Node") and not of(executed, "ExecuteProcess")
    starts, simulator = simulator_of(executed)
    # Once: a node may be activated again.
    assert starts.handle_once and starts.target is None
    stubs.run([simulator], stubs.LaunchContext())
    assert simulator.words == ["handover_mesh", "handover_sim", "node"]
    assert (simulator.node_name, simulator.namespace) == ("handover_sim", "")
    assert simulator.files == []
    assert simulator.values == {
        "seed": 0, "speed": 1.0, "loop": False, "clock": False, "tf": False, "exit_at_end": True,
        "listeners": 1}
    table = (ROOT / "docs" / "simulator.md").read_text()
    assert all(f"| `{name}` |" in table for name in simulator.values)
    ends, = handlers(executed, "OnProcessExit")
    assert ends.target_action is simulator
    assert type(ends.entities[0].event).__name__ == "Shutdown"
    assert node.values == {"use_sim_time": False}


def test_a_replays_arguments_reach_simulator_and_node(execute, stubs):
    executed = execute(
        "replay", model="/m", role="receiver", rate="50", recording="/clip.csv", seed="7",
        speed="2", loop="true", clock="true", tf="true", simulator_params_file="/s.yaml",
        params_file="/p.yaml", namespace="/ns", name="left", log_level="warn", autostart="false")
    node, = of(executed, "LifecycleNode")
    assert (node.node_name, node.namespace, node.files) == ("left", "/ns", ["/p.yaml"])
    assert node.values == {"node.model": "/m", "node.role": "receiver", "node.rate": 50.0,
                           "use_sim_time": True}
    assert node.ros_arguments == ["--log-level", "warn"]
    assert not handlers(executed, "OnProcessStart")
    _, simulator = simulator_of(executed)
    stubs.run([simulator], stubs.LaunchContext())
    assert simulator.namespace == "/ns" and simulator.files == ["/s.yaml"]
    assert simulator.values == {
        "recording": "/clip.csv", "seed": 7, "speed": 2.0, "loop": True, "clock": True,
        "tf": True, "role": "receiver", "exit_at_end": True,
        "listeners": 1}
    assert simulator.ros_arguments == ["--log-level", "warn"]


def test_targets_are_echoed_or_recorded(execute):
    echo, = of(execute("replay", targets="echo", namespace="ns"), "ExecuteProcess")
    assert echo.words == ["/bin/ros2", "topic", "echo", "/ns/handover/joint_targets"]
    echo, = of(execute("replay", targets="echo"), "ExecuteProcess")
    assert echo.words[-1] == "/handover/joint_targets"
    executed = execute("replay", targets="record", namespace="ns", output="/tmp/bag",
                       storage="sqlite3", clock="true")
    record, = of(executed, "ExecuteProcess")
    assert record.words[3:5] == ["--storage", "sqlite3"]
    assert record.words[-3:] == ["--output", "/tmp/bag", "--use-sim-time"]
    assert "/ns/handover/joint_targets" in recorded(record.words)
    # The recorder is there before the node says anything.
    node, = of(executed, "LifecycleNode")
    assert executed.index(record) < executed.index(node)


@pytest.mark.parametrize(("name", "argument", "text", "words"), [
    ("handover", "rate", "fast", "must be a number"), ("replay", "rate", "30 Hz", "must be a number"),
    ("replay", "speed", "twice", "must be a number"),
    ("replay", "seed", "1.5", "must be a whole number")])
def test_what_is_no_number_is_said_by_its_name(execute, name, argument, text, words):
    with pytest.raises(RuntimeError, match=f'^Argument "{argument}" is "{text}", {words}.$'):
        execute(name, **{argument: text})


@pytest.mark.parametrize("source", ["skeleton", "tf", "markers"])
def test_the_simulator_sends_where_the_node_looks(execute, stubs, source):
    executed = execute("replay", source=source)
    node, = of(executed, "LifecycleNode")
    assert node.values["node.source"] == source
    _, simulator = simulator_of(executed)
    stubs.run([simulator], stubs.LaunchContext())
    assert simulator.values[source] is True
    assert simulator.values["skeleton"] is (source == "skeleton")
    assert simulator.values["tf"] is (source == "tf")


def test_the_stand_ins_refuse_what_the_real_ones_refuse(stubs):
    actions, handlers, conditions, ros_actions, ros_handlers, lifecycle, parameters = map(
        importlib.import_module,
        ["launch.actions", "launch.event_handlers", "launch.conditions", "launch_ros.actions",
         "launch_ros.event_handlers", "launch_ros.events.lifecycle",
         "launch_ros.parameter_descriptions"])
    value = parameters.ParameterValue
    # What is substituted is coerced, what is there already is not.
    rate = importlib.import_module("launch.substitutions").LaunchConfiguration("rate")
    assert value(rate, value_type=float).evaluate(stubs.LaunchContext({"rate": "3"})) == 3.0
    node = {"package": "p", "executable": "e", "name": "n", "namespace": ""}
    process = actions.ExecuteProcess(cmd=["true"])
    for kind, wrong in [
            (TypeError, lambda: value("false", value_type=bool)),
            (TypeError, lambda: value("30", value_type=float)),
            (TypeError, lambda: value(30, value_type=float)),
            (ValueError, lambda: value("30", value_type=bytes)),
            (TypeError, lambda: actions.ExecuteProcess(cmd=["sleep", 1])),
            (TypeError, lambda: actions.LogInfo(msg=1)),
            (TypeError, lambda: actions.LogInfo(msg="", condition=True)),
            (TypeError, lambda: actions.OpaqueFunction(function="start")),
            (TypeError, lambda: actions.DeclareLaunchArgument("a", default_value=False)),
            (RuntimeError, lambda: actions.DeclareLaunchArgument(
                "a", default_value="c", choices=["a", "b"])),
            (TypeError, lambda: actions.IncludeLaunchDescription(
                None, launch_arguments={"clock": True}.items())),
            (RuntimeError, lambda: actions.EmitEvent(event=process)),
            (TypeError, lambda: conditions.IfCondition(True)),
            (TypeError, lambda: handlers.OnProcessExit(target_action=7, on_exit=[process])),
            (TypeError, lambda: handlers.OnProcessExit(on_exit=["text"])),
            (TypeError, lambda: ros_actions.Node(parameters={"a": 1}, **node)),
            (TypeError, lambda: ros_actions.Node(parameters=[{"a": None}], **node)),
            (TypeError, lambda: ros_actions.Node(remappings=[("a", 1)], **node)),
            (TypeError, lambda: ros_actions.Node(ros_arguments=[1], **node)),
            (RuntimeError, lambda: ros_actions.LifecycleNode(**{**node, "name": None})),
            (TypeError, lambda: ros_actions.LifecycleNode(package="p", executable="e", name="n")),
            (RuntimeError, lambda: ros_handlers.OnStateTransition(
                entities=[process], target_lifecycle_node=process)),
            (ValueError, lambda: lifecycle.ChangeState(
                lifecycle_node_matcher=lambda node: True, transition_id=99))]:
        with pytest.raises(kind):
            wrong()


def installed(folder):
    """A folder with the files laid out as an installed package has them; its programs do nothing."""
    share = folder / "share/handover_mesh"
    share.mkdir(parents=True)
    for name in ["launch", "config"]:
        (share / name).symlink_to(ROOT / name)
    index = folder / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    (index / "handover_mesh").touch()
    for program in ["lib/handover_mesh/handover_node", "lib/handover_mesh/handover_sim", "bin/ros2"]:
        path = folder / program
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#!/bin/sh\n")
        path.chmod(0o755)
    return folder


@pytest.mark.parametrize(("name", "arguments"), [
    ("handover", {}), ("handover", {"rate": "60", "role": "1", "use_sim_time": "true"}),
    ("record", {"output": "/tmp/bag", "use_sim_time": "true"}),
    ("replay", {}), ("replay", {"targets": "echo", "source": "tf", "seed": "3", "role": "giver"}),
    ("replay", {"targets": "record", "clock": "true", "loop": "true", "speed": "2"})])
def test_the_real_launch_takes_every_file(name, arguments, tmp_path):
    """All actions made, included files too, parameters and commands evaluated; nothing started."""
    # Not `launch`: any folder of that name would do.
    pytest.importorskip("launch.actions", reason="no launch here: only stand-ins were used")
    pytest.importorskip("launch_ros.actions", reason="no launch_ros here: only stand-ins were used")
    code = f"""
import launch, launch.actions, launch.utilities, launch_ros.actions
from launch.launch_description_sources import PythonLaunchDescriptionSource

context = launch.LaunchContext()
context.launch_configurations.update({arguments!r})
seen = []

def go(entity):
    seen.append(type(entity).__name__)
    if isinstance(entity, launch_ros.actions.Node):
        entity._perform_substitutions(context)
    elif isinstance(entity, launch.actions.ExecuteProcess):
        for word in entity.cmd:
            launch.utilities.perform_substitutions(context, word)
    else:
        if isinstance(entity, launch.actions.RegisterEventHandler):
            for later in entity.event_handler.describe()[1]:
                if isinstance(later, launch_ros.actions.Node):
                    go(later)
        for one in entity.visit(context) or []:
            go(one)

path = {str(ROOT / 'launch' / f'{name}.launch.py')!r}
go(PythonLaunchDescriptionSource(path).get_launch_description(context))
wanted = {{"handover": ["LifecycleNode"], "record": ["ExecuteProcess"],
           "replay": ["LifecycleNode", "Node"]}}[{name!r}]
assert set(wanted) <= set(seen), seen
"""
    prefix = installed(tmp_path / "prefix")
    environment = {
        **os.environ, "PATH": f"{prefix}/bin:{os.environ['PATH']}",
        "AMENT_PREFIX_PATH": f"{prefix}:{os.environ.get('AMENT_PREFIX_PATH', '')}".strip(":"),
        "ROS_LOG_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True,
                          timeout=60, env=environment, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
