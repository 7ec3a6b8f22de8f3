"""The handover node's life and parameters, as launch files and `ros2 param` lead them."""

import errno
import math
import os
import signal

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParametersAtomically
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from conftest import ROOT
from handover import (DEEP_RELIABLE, GIVER, LATCHED, RECEIVER, Meeting, distance, median_step,
                      nanoseconds, place_of)
from processes import wait_for

NODE = "/handover"


@pytest.fixture
def waiting(handover):
    """A node that waits to be configured."""
    return handover({"node.autostart": False})


def test_the_whole_life(waiting, ros, clip):
    events = ros.listen(TransitionEvent, f"{NODE}/transition_event", QoSProfile(depth=100))
    meeting = Meeting(ros, clip)
    assert ros.state(NODE) == "unconfigured"
    assert not ros.change_state(NODE, "activate"), "not before it is configured"

    def is_heard():
        """an event: whoever listens has to be found first"""
        assert ros.change_state(NODE, "configure") and ros.change_state(NODE, "cleanup")
        return events.count > 0
    wait_for(is_heard, 30)
    begun = nanoseconds(ros.now())
    assert ros.change_state(NODE, "configure")
    assert ros.state(NODE) == "inactive"
    meeting.play(end=10)
    assert not ros.call(Trigger, f"{NODE}/cancel").success
    activated = nanoseconds(ros.now())
    assert ros.change_state(NODE, "activate")
    assert ros.state(NODE) == "active"
    meeting.begin()
    assert ros.change_state(NODE, "deactivate")
    # What has an older stamp was on its way when the service answered.
    deactivated = nanoseconds(ros.now())
    late = ros.listen(String, f"{NODE}/handover_state", LATCHED)
    assert late.wait()[-1].data == "idle", "whoever asks later is not told what was"
    meeting.play(start=30, end=40)
    again = nanoseconds(ros.now())
    assert ros.change_state(NODE, "activate"), "as often as one likes"
    meeting.begin()
    # Targets come in order: after one of now nothing older comes.
    assert not meeting.said(0, activated) and not meeting.said(deactivated, again), (
        "an inactive node says nothing")
    assert ros.change_state(NODE, "deactivate") and ros.change_state(NODE, "cleanup")
    assert ros.state(NODE) == "unconfigured"
    expected = ["configuring", "inactive", "activating", "active", "deactivating", "inactive",
                "activating", "active", "deactivating", "inactive", "cleaningup", "unconfigured"]

    def told():
        """all steps of its life"""
        return [event.goal_state.label for event in events.messages if event.timestamp > begun]
    wait_for(lambda: len(told()) >= len(expected), what=told.__doc__)
    assert told() == expected
    assert ros.change_state(NODE, "unconfigured_shutdown")
    assert waiting.wait() == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_clean(handover, ros, clip, number):
    process = handover()
    Meeting(ros, clip).begin()
    process.stop(number)
    assert process.ended() == (0,)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_clean_while_it_configures(programs, work, number):
    # Of a model that never comes to an end the reader waits.
    endless = work / "endless"
    os.mkfifo(endless)
    process = programs.start("handover_node", parameters={
        "node.model": str(endless), "node.autostart": True})

    def is_read():
        """the model is being read"""
        try:
            return os.fdopen(os.open(endless, os.O_WRONLY | os.O_NONBLOCK), "wb")
        except OSError as error:
            assert error.errno == errno.ENXIO, error
            return None
    with wait_for(is_read, process=process):
        process.stop(number)
    assert process.ended() == (0,)


def test_what_is_set_wins_over_the_model_even_if_it_was_so_before(
        handover, ros, programs, recordings, work):
    slow = work / "slow.safetensors"
    programs.run("handover", "learn", recordings, "--role", "giver", "--method", "none",
                 "--set", "safety.speed=3.0", "-o", slow)
    handover({"node.model": str(slow), "node.autostart": False})
    assert ros.change_state(NODE, "configure")
    assert ros.get_parameters(NODE, "safety.speed") == [3.0], "the model's"
    assert ros.change_state(NODE, "cleanup")
    assert ros.set_parameters(NODE, safety__speed=3.0)["safety.speed"][0]
    assert ros.set_parameters(NODE, safety__speed=1.7)["safety.speed"][0]
    assert ros.set_parameters(NODE, safety__speed=1.7)["safety.speed"][0]
    assert ros.change_state(NODE, "configure")
    assert ros.get_parameters(NODE, "safety.speed") == [1.7]


@pytest.mark.parametrize("lives", [1, 3])
def test_a_robot_that_says_nothing_goes_on_from_where_it_stands(handover, ros, clip, lives):
    base = clip.people[0][GIVER]["torso"]
    # The recorded giver looks at the receiver.
    there = clip.people[0][RECEIVER]["torso"]
    yaw = math.atan2(there[1] - base[1], there[0] - base[0])
    handover({"node.robot_state": "demonstrated", "node.world_from_base": [*base, 0.0, 0.0, yaw]})
    meeting = Meeting(ros, clip)

    def first_after(since):
        said = wait_for(lambda: meeting.said(since), what="a target")
        return place_of(said[0], "right_hand")
    first = first_after(0)
    meeting.begin()
    meeting.play(end=clip.closest())
    assert ros.change_state(NODE, "deactivate")
    deactivated = nanoseconds(ros.now())
    for _ in range(lives - 1):
        # Over before the robot stands, and so before a tick.
        assert ros.change_state(NODE, "activate") and ros.change_state(NODE, "deactivate")
    assert ros.change_state(NODE, "activate")
    begins = first_after(deactivated)
    stands = place_of(meeting.said(0, deactivated)[-1], "right_hand", -1)
    assert distance(first, stands) > 0.05, "it had moved"
    assert distance(begins, stands) < 1e-6
    # Cleaned up, it is another robot.
    assert ros.change_state(NODE, "deactivate") and ros.change_state(NODE, "cleanup")
    cleaned_up = nanoseconds(ros.now())
    assert ros.change_state(NODE, "configure") and ros.change_state(NODE, "activate")
    assert distance(first_after(cleaned_up), first) < 1e-6


def test_a_robot_that_reports_is_waited_for_until_it_stands(handover, ros, clip):
    handover()
    meeting = Meeting(ros, clip)
    meeting.begin()
    meeting.play(end=clip.closest())
    assert ros.change_state(NODE, "deactivate")
    deactivated = nanoseconds(ros.now())
    last = meeting.said(0, deactivated)[-1]
    stands = nanoseconds(last.header.stamp) + nanoseconds(last.points[-1].time_from_start)
    assert stands > deactivated + 50_000_000, "it still brakes"
    assert ros.change_state(NODE, "activate")

    def goes_on():
        """a target"""
        meeting.show(clip.closest())
        return meeting.said(deactivated)
    assert nanoseconds(wait_for(goes_on)[0].header.stamp) >= stands


def test_what_is_set_while_it_configures_counts(waiting, ros):
    statuses = ros.listen(DiagnosticArray, "/diagnostics", DEEP_RELIABLE)
    change = ros.node.create_client(ChangeState, f"{NODE}/change_state")
    wait_for(change.service_is_ready, what="the service")
    request = ChangeState.Request()
    request.transition.id = Transition.TRANSITION_CONFIGURE
    configured = change.call_async(request)
    # Nobody hears its events, so that it takes a second.
    wait_for(lambda: ros.state(NODE) == "configuring", what="configuring")
    rate = {"node.diagnostics_rate": (True, "")}
    assert ros.set_parameters(NODE, node__diagnostics_rate=50.0) == rate
    assert ros.state(NODE) == "configuring"
    wait_for(configured.done, what="the end of it")
    assert configured.result().success and ros.change_state(NODE, "activate")
    statuses.wait(40)
    assert median_step(statuses.messages) < 0.03


def test_states_and_transitions_are_those_of_lifecycle_nodes(waiting, ros):
    states = ros.call(GetAvailableStates, f"{NODE}/get_available_states").available_states
    assert {state.label for state in states} >= {"unconfigured", "inactive", "active", "finalized"}
    ways = ros.call(GetAvailableTransitions, f"{NODE}/get_available_transitions")
    assert [way.transition.label for way in ways.available_transitions] == ["configure", "shutdown"]
    graph = ros.call(GetAvailableTransitions, f"{NODE}/get_transition_graph")
    ways = {(way.start_state.label, way.transition.label, way.goal_state.label)
            for way in graph.available_transitions}
    assert ("inactive", "activate", "activating") in ways and len(ways) == 25


@pytest.mark.parametrize(("parameters", "words"), [
    ({"node.model": ""}, "node.model is not set"),
    ({"node.model": "/nowhere/model.safetensors"}, "/nowhere/model.safetensors"),
    ({"node.model": str(ROOT / "README.md")}, "README.md"),
    ({"node.role": "receiver"}, "node.role is receiver, but the robot of"),
    ({"safety.lead": 0.4}, "must be at least safety.lead, 0.4"),
])
def test_what_cannot_be_configured_is_said_and_may_be_mended(
        handover, ros, model, parameters, words):
    process = handover({"node.autostart": False, **parameters})
    assert not ros.change_state(NODE, "configure")
    assert ros.state(NODE) == "unconfigured"
    process.says(words)
    process.says("unconfigured: waits for ~/change_state")
    taken = ros.set_parameters(NODE, node__model=str(model), node__role="", safety__lead=0.05)
    assert all(success for success, _ in taken.values()), taken
    assert ros.change_state(NODE, "configure")


def test_the_shipped_file_is_a_parameter_file(handover, ros, model):
    handover({"node.autostart": False}, params_file=ROOT / "config" / "handover.yaml")
    names = ros.call(ListParameters, f"{NODE}/list_parameters").result.names
    assert {"safety.speed", "filter.stale", "node.rate", "use_sim_time", "mesh.kernel"} <= set(names)
    assert ros.get_parameters(NODE, "safety.speed", "node.world_frame") == [1.7, "world"]
    assert ros.change_state(NODE, "configure")


def test_parameters_say_what_they_are(waiting, ros):
    names = ["safety.speed", "track.demonstrations", "node.source", "mesh.scale", "nonsense"]
    request = DescribeParameters.Request(names=names)
    speed, count, source, scale, nonsense = ros.call(
        DescribeParameters, f"{NODE}/describe_parameters", request).descriptors
    assert "[m/s]" in speed.description and not speed.read_only
    (bounds,) = speed.floating_point_range
    assert (bounds.from_value, bounds.to_value) == (0.01, 10.0)
    assert count.type == ParameterType.PARAMETER_INTEGER
    assert count.integer_range[0].to_value == 1000
    assert source.read_only and "skeleton, tf, markers" in source.additional_constraints
    assert scale.read_only, "it belongs to the model"
    assert nonsense.type == ParameterType.PARAMETER_NOT_SET


def test_parameters_are_set_or_refused_with_a_reason(waiting, ros):
    def reason(**values):
        ((success, words),) = ros.set_parameters(NODE, **values).values()
        assert not success
        return words

    assert "must be a number from 0.01 to 10" in reason(safety__speed=50.0)
    assert "must be a number" in reason(safety__speed="fast")
    assert "belongs to the model" in reason(mesh__scale=3.0)
    assert "safety.spede is no parameter" in reason(safety__spede=1.0)
    assert "no numbers, or six" in reason(safety__workspace=[1.0, 2.0])
    assert "has none" in reason(node__partner=3), "the topic skeleton numbers nobody"
    assert ros.set_parameters(NODE, safety__speed=1)["safety.speed"] == (True, "")
    assert ros.get_parameters(NODE, "safety.speed") == [1.0]
    # Together or not at all.
    both = [Parameter(name="safety.speed", value=ParameterValue(
                type=ParameterType.PARAMETER_DOUBLE, double_value=0.5)),
            Parameter(name="safety.jerk", value=ParameterValue(
                type=ParameterType.PARAMETER_DOUBLE, double_value=-1.0))]
    request = SetParametersAtomically.Request(parameters=both)
    answer = ros.call(SetParametersAtomically, f"{NODE}/set_parameters_atomically", request)
    assert not answer.result.successful and "safety.jerk" in answer.result.reason
    assert ros.get_parameters(NODE, "safety.speed") == [1.0]
    assert ros.change_state(NODE, "configure")
    assert "clean it up first" in reason(safety__speed=0.5)
    assert ros.set_parameters(NODE, node__start_zone=2.0)["node.start_zone"] == (True, "")


def test_all_that_is_wrong_at_the_start_is_said_at_once(programs):
    process = programs.start("handover_node", parameters={
        "safety.speed": 99.0, "node.sorce": "tf", "mesh.kernel": "square"})
    assert process.wait() == 2
    for words in ["safety.speed is 99", "node.sorce is no parameter", "mesh.kernel is \"square\""]:
        assert words in process.stderr()


def test_help_and_unknown_arguments(programs):
    assert "node.model" in programs.run("handover_node", "--help")
    process = programs.start("handover_node", "--frobnicate")
    assert process.wait() == 2 and "--frobnicate" in process.stderr()
