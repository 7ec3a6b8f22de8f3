"""`handover_sim node` as a process: what is heard of it, asked of it, and what is left of it."""

import itertools
import math
import pathlib
import signal
import statistics
import time

import pytest
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Parameter, ParameterEvent
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameterTypes,
    ListParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter as Value
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import MultiDOFJointState
from std_msgs.msg import Bool
from visualization_msgs.msg import MarkerArray

from handover import RECEIVER, nanoseconds
from peer import DEEP, DEEP_RELIABLE, LATCHED, RELIABLE
from processes import wait_for

NODE = "/handover_sim"


def stamps(messages):
    return [nanoseconds(message.header.stamp) for message in messages]


@pytest.fixture
def simulator(programs):
    """Starts the node; `wait` in its parameters gives whoever listens time to be found."""
    def start(**parameters):
        parameters = {name.replace("__", "."): value for name, value in parameters.items()}
        return programs.start("handover_sim", "node",
                              parameters={"start_delay": 1.5, **parameters})
    return start


def is_over(ros):
    finished = ros.listen(Bool, f"{NODE}/finished", LATCHED)
    wait_for(lambda: finished.last is not None and finished.last.data, 20.0, "the end")


def test_a_recording_is_heard_as_it_is(simulator, ros, clip):
    times, joints = clip.times, [people[RECEIVER] for people in clip.people]
    partner = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    robot = ros.listen(MultiDOFJointState, "robot_skeleton", DEEP)
    objects = ros.listen(PoseStamped, "object_pose", DEEP)
    markers = ros.listen(MarkerArray, "skeleton_markers", DEEP)
    before = time.time_ns()
    process = simulator(recording=str(clip.path), markers=True, body=3, world_frame="map",
                        listeners=1)
    is_over(ros)
    # Best effort, and this machine may be busy: some may be missing, those that came are in order.
    for all_of_it in [partner, robot, objects, markers]:
        all_of_it.wait(math.ceil(0.8 * len(times)))
        assert all_of_it.count <= len(times)
    entries = list(partner.entries)
    sent, heard = [list(column) for column in zip(*entries, strict=True)]
    assert stamps(heard) == sorted(set(stamps(heard)))
    assert before < stamps(heard)[0] < time.time_ns()
    starts = []
    left = list(zip(times, joints, strict=True))
    for message in heard:
        assert message.header.frame_id == "map"
        places = {name: [place.x, place.y, place.z] for name, place in
                  zip(message.joint_names, [transform.translation for transform in
                                            message.transforms], strict=True)}
        while left and left[0][1] != places:
            left.pop(0)
        assert left, f"not in the recording, or out of order: {places}"
        assert all(transform.rotation.w == 1.0 for transform in message.transforms)
        starts.append(nanoseconds(message.header.stamp) - left.pop(0)[0] * 1e9)
    # To the nanosecond at one pace, but that a file's times are kept as seconds here.
    assert max(starts) - min(starts) < 1e3
    # By the times at which the simulator sent them: this process may be late.
    late = [b - a - (d - c) for a, b, c, d in
            zip(sent, sent[1:], stamps(heard), stamps(heard)[1:], strict=False)]
    print("jitter of sending [ms]: median", statistics.median(map(abs, late)) / 1e6,
          "most", max(map(abs, late)) / 1e6)
    assert statistics.median(map(abs, late)) < 5e6
    ids = {marker.id // 100 for message in markers.messages for marker in message.markers}
    assert ids == {3} and len(markers.messages[0].markers) == 15
    # It stays, so that launch does not take it for a crash.
    time.sleep(0.3)
    assert not process.ended()


def test_transforms_are_sent_or_said_to_be_missing(simulator, ros):
    messages = pytest.importorskip("tf2_msgs.msg")
    heard = ros.listen(messages.TFMessage, "/tf", RELIABLE)
    process = simulator(start_delay=0.0, loop=True, body=2)
    wait_for(lambda: heard.count > 10 or "no /tf" in process.stderr(), 10.0, "transforms", process)
    if heard.count:
        names = {edge.child_frame_id for edge in heard.last.transforms}
        assert len(names) == 15 and "left_hand_2" in names
        assert heard.last.transforms[0].header.frame_id == "world"


def test_what_is_not_to_be_sent_is_no_topic_and_the_rest_goes_on(simulator, ros):
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    simulator(start_delay=0.0, loop=True, tf=False, robot_skeleton=False)
    heard.wait(5)
    # The last one that it makes.
    wait_for(lambda: f"{NODE}/finished" in published(ros), what="all that it publishes")
    assert {"/skeleton", "/object_pose"} <= published(ros)
    assert not {"/tf", "/robot_skeleton", "/skeleton_markers", "/clock"} & published(ros)


def published(ros):
    """The topics that the simulator publishes, as far as they are known here."""
    if NODE not in ros.nodes():
        return set()
    pairs = ros.node.get_publisher_names_and_types_by_node(NODE.strip("/"), "/")
    return {name for name, _ in pairs}


def test_quality_of_the_topics(simulator, ros):
    simulator(loop=True, clock=True, markers=True)
    def offered(topic):
        infos = ros.node.get_publishers_info_by_topic(topic)
        return [(int(info.qos_profile.reliability), int(info.qos_profile.durability))
                for info in infos]
    reliable, best_effort, kept, volatile = 1, 2, 1, 2
    wait_for(lambda: offered("/handover_sim/finished"), 10.0, "the topics")
    wait_for(lambda: offered("/clock"), 10.0, "the clock")
    for topic in ["/skeleton", "/robot_skeleton", "/object_pose"]:
        assert offered(topic) == [(best_effort, volatile)], topic
    for topic in ["/skeleton_markers", "/clock"]:
        assert offered(topic) == [(reliable, volatile)], topic
    assert offered("/handover_sim/finished") == [(reliable, kept)]


def test_four_times_as_fast_and_again_and_again(simulator, ros):
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    simulator(speed=4.0, loop=True, pause=0.5, seed=2)
    wait_for(lambda: any(b - a > 4e8 for a, b in zip(stamps(heard.messages),
                                                     stamps(heard.messages)[1:])),
             20.0, "a second time")
    heard.wait(heard.count + 20)
    gaps = [(b - a) / 1e9 for a, b in zip(stamps(heard.messages), stamps(heard.messages)[1:])]
    assert statistics.median(gaps) == pytest.approx(1 / 120, abs=1e-6)
    assert max(gaps) == pytest.approx(0.5, abs=0.05)


def test_another_rate(simulator, ros):
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    simulator(rate=100.0, start_delay=0.5, listeners=1)
    heard.wait(100)
    gaps = [(b - a) / 1e9 for a, b in zip(stamps(heard.messages), stamps(heard.messages)[1:])]
    assert statistics.median(gaps) == pytest.approx(0.01, abs=1e-6)


def test_a_clock_of_its_own(simulator, ros):
    clock = ros.listen(Clock, "/clock", DEEP)
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    simulator(clock=True, clock_start=50.0, speed=2.0, start_delay=4.0, listeners=1)
    heard.wait(60)
    entries = list(clock.entries)
    times = [nanoseconds(message.clock) for _, message in entries]
    assert times == sorted(times)
    assert 50e9 <= times[0] < 54e9 <= stamps(heard.messages)[0]
    # Twice as fast as the world, while frames keep their distance.
    begin, end = entries[0][0], entries[-1][0]
    assert (times[-1] - times[0]) / (end - begin) == pytest.approx(2.0, rel=0.05)
    gaps = [b - a for a, b in zip(stamps(heard.messages), stamps(heard.messages)[1:])]
    assert statistics.median(gaps) == pytest.approx(1e9 / 30, rel=1e-3)
    rate = len(times) / ((end - begin) / 1e9)
    print("/clock [Hz]:", rate)
    assert rate > 100
    # Paused, time stands still, for everybody.
    assert ros.set_parameters(NODE, paused=True) == {"paused": (True, "")}

    def still():
        """a hundred times the same time"""
        told = {nanoseconds(message.clock) for message in clock.messages[-100:]}
        return told.pop() if len(told) == 1 else None
    stood = wait_for(still)
    ros.set_parameters(NODE, paused=False)
    wait_for(lambda: nanoseconds(clock.last.clock) > stood, what="time to go on")


def test_time_of_somebody_else(simulator, ros):
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    simulator(use_sim_time=True, start_delay=0.1, tf=False, listeners=1)
    clock = ros.publisher(Clock, "/clock", RELIABLE, subscribers=1)
    time.sleep(0.5)
    assert heard.count == 0, "there is no time yet"
    for step in range(400):
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(7 * 10**9 + step * 10**7, 10**9)
        clock.publish(message)
        time.sleep(0.005)
    heard.wait(30)
    assert 7.05e9 < stamps(heard.messages)[0]
    assert stamps(heard.messages)[-1] <= 11e9


def test_faults_are_switched_by_parameters(simulator, ros):
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    robot = ros.listen(MultiDOFJointState, "robot_skeleton", DEEP)
    simulator(loop=True, pause=0.0, start_delay=0.5, sensor__kind="kinect")
    heard.wait(10)
    kinect = ros.get_parameters(NODE, "sensor.kind", "sensor.frame_loss", "sensor.joint_noise")
    assert kinect == ["kinect", 0.02, 0.005]
    events = ros.listen(ParameterEvent, "/parameter_events", RELIABLE)

    def told():
        """an event of the change"""
        # Anew each time: whoever listens has to be found first.
        for loss in [0.7, 0.8]:
            answer = ros.set_parameters(NODE, sensor__frame_loss=loss)
            assert answer == {"sensor.frame_loss": (True, "")}
        return any(parameter.name == "sensor.frame_loss" for event in events.messages
                   if event.node == NODE for parameter in event.changed_parameters)
    wait_for(told, 10.0)

    def seen_since(since, count):
        """Of so many frames from a time [ns] on: the part that the sensor did not lose."""
        def later(heard):
            return {stamp for stamp in stamps(heard.messages) if stamp > since}
        # What was sent in one go may come in one after the other.
        wait_for(lambda: len(later(robot)) > count, 20.0, f"{count} frames")
        frames = sorted(later(robot))[:count]
        return sum(frames[0] <= stamp <= frames[-1] for stamp in later(heard)) / count
    assert ros.get_parameters(NODE, "sensor.kind") == ["custom"]
    assert 0.05 < seen_since(nanoseconds(ros.now()), 150) < 0.4
    # All faults off again, at once.
    ros.set_parameters(NODE, sensor__kind="ideal")
    assert ros.get_parameters(NODE, "sensor.frame_loss", "sensor.kind") == [0.0, "ideal"]
    assert seen_since(nanoseconds(ros.now()), 60) > 0.9


def test_paused_and_faster_while_it_runs(simulator, ros):
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    simulator(loop=True, start_delay=0.2, rate=50.0, pause=0.0)
    heard.wait(10)
    assert ros.set_parameters(NODE, paused=True) == {"paused": (True, "")}
    paused = nanoseconds(ros.now())
    time.sleep(0.5)
    resumed = nanoseconds(ros.now())
    assert ros.set_parameters(NODE, speed=2.0, paused=False) == {"speed": (True, ""),
                                                                 "paused": (True, "")}

    def later():
        """frames from then on"""
        found = [stamp for stamp in stamps(heard.messages) if stamp > resumed]
        return found if len(found) > 30 else None
    after = wait_for(later)
    assert not [stamp for stamp in stamps(heard.messages) if paused < stamp < resumed]
    gaps = [b - a for a, b in zip(after, after[1:])]
    assert statistics.median(gaps) == pytest.approx(1e7, rel=1e-3)


def test_parameters_are_described_listed_and_refused(simulator, ros):
    simulator(loop=True)
    names = ["speed", "seed", "sensor.kind", "recording", "nothing"]
    described = ros.call(DescribeParameters, f"{NODE}/describe_parameters",
                         DescribeParameters.Request(names=names)).descriptors
    speed, seed, kind, recording, nothing = described
    ranges = speed.floating_point_range
    assert [(r.from_value, r.to_value) for r in ranges] == [(0.01, 100.0)]
    assert not speed.read_only and "as recorded" in speed.description
    assert seed.read_only and seed.integer_range[0].to_value == 2**63 - 1
    assert kind.additional_constraints == "one of ideal, kinect, custom"
    assert recording.read_only and recording.type == 4
    assert (nothing.name, nothing.type) == ("nothing", 0)
    types = ros.call(GetParameterTypes, f"{NODE}/get_parameter_types",
                     GetParameterTypes.Request(names=names)).types
    assert list(types) == [3, 2, 4, 4, 0]
    listed = ros.call(ListParameters, f"{NODE}/list_parameters",
                      ListParameters.Request(prefixes=["sensor"], depth=1)).result
    assert "sensor.frame_loss" in listed.names and "sensor.position.x" not in listed.names
    everything = ros.call(ListParameters, f"{NODE}/list_parameters").result
    assert {"use_sim_time", "sensor.position.x", "loop"} <= set(everything.names)
    assert set(everything.prefixes) == {"sensor", "sensor.position"}
    answers = ros.set_parameters(NODE, speed=1000.0, seed=3, sped=1.0, loop="on",
                                 sensor__kind="lidar")
    reason = {name: reason for name, (taken, reason) in answers.items() if not taken}
    assert reason["speed"] == "speed is 1000.0, must be a number from 0.01 to 100"
    assert reason["seed"] == ("seed cannot be changed while the node runs: it is taken when the "
                              "node starts")
    assert reason["sped"].startswith("sped is no parameter; there are recording, seed, ")
    assert reason["loop"] == 'loop is "on", must be true or false'
    assert reason["sensor.kind"] == 'sensor.kind is "lidar", must be one of ideal, kinect, custom'
    assert ros.set_parameters(NODE, speed=2) == {"speed": (True, "")}
    assert ros.get_parameters(NODE, "speed", "nothing") == [2.0, None]
    # All or none.
    def atomically(**values):
        parameters = [Parameter(name=name, value=Value(name, value=value).get_parameter_value())
                      for name, value in values.items()]
        request = SetParametersAtomically.Request(parameters=parameters)
        return ros.call(SetParametersAtomically, f"{NODE}/set_parameters_atomically",
                        request).result
    assert not atomically(loop=False, speed=-1.0).successful
    assert ros.get_parameters(NODE, "loop", "speed") == [True, 2.0]
    assert atomically(loop=False, speed=3.0).successful
    assert ros.get_parameters(NODE, "loop", "speed") == [False, 3.0]


def test_all_that_is_wrong_at_the_start_is_said_at_once(programs, work):
    file = work / "wrong.yaml"
    file.write_text("/**:\n  ros__parameters:\n    speed: 0.0\n    sensor: {frame_loss: 2, haze: 1}\n"
                    "    loop: 3\n")
    process = programs.start("handover_sim", "node", params_file=file, parameters={"role": 7})
    assert process.wait() == 2
    for line in ["speed is 0.0, must be a number from 0.01 to 100",
                 "sensor.frame_loss is 2, must be a number from 0 to 0.9",
                 "sensor.haze is no parameter; there are sensor.kind, ",
                 "loop is 3, must be true or false",
                 "role is 7, must be text"]:
        assert line in process.stderr(), process.stderr()


@pytest.mark.parametrize(("parameters", "words"), [
    ({"role": "waiter"}, 'role is "waiter", must be giver or receiver'),
    ({"recording": "/nowhere/clip.csv"}, "/nowhere/clip.csv: No such file"),
    ({"recording": __file__}, "test_simulator.py: "),
])
def test_what_cannot_be_played_is_said(programs, parameters, words):
    process = programs.start("handover_sim", "node", parameters=parameters)
    assert process.wait() == 2
    assert words in process.stderr()


@pytest.mark.parametrize(("arguments", "words"), [
    (["-p", "bad"], "Couldn't parse parameter override rule: '-p bad'"),
    (["--params-file", "/nowhere/parameters.yaml"], "/nowhere/parameters.yaml"),
    (["--param-file", "a.yaml"], "unknown arguments of ROS: --param-file a.yaml"),
])
def test_malformed_arguments_are_said(programs, arguments, words):
    process = programs.start("handover_sim", "node", "--ros-args", *arguments)
    assert process.wait() == 2
    assert f"error: {words.split('/')[0]}" in process.stderr() and words in process.stderr()
    assert "panicked" not in process.stderr()


def test_what_yaml_takes_for_a_truth_is_a_choice(simulator, ros, clip):
    simulator(recording=str(clip.path), up="y")
    assert ros.get_parameters(NODE, "up") == ["y"]


def test_a_name_and_a_namespace(programs, ros):
    programs.start("handover_sim", "node", name="camera", namespace="/left",
                   parameters={"loop": True, "start_delay": 0.0},
                   remap={"skeleton": "/somebody"})
    assert ros.listen(MultiDOFJointState, "/somebody", DEEP).wait(3)
    assert ros.listen(MultiDOFJointState, "/left/robot_skeleton", DEEP).wait(3)
    assert ros.get_parameters("/left/camera", "loop") == [True]


def test_it_ends_by_itself_when_told_to(programs, ros):
    finished = ros.listen(Bool, f"{NODE}/finished", LATCHED)
    # First the other: who is discovered in turn, is known to the node before this one is.
    ros.listen(MultiDOFJointState, "skeleton", DEEP)
    process = programs.start("handover_sim", "node", parameters={
        "exit_at_end": True, "speed": 10.0, "start_delay": 1.0, "listeners": 1})
    assert process.wait(20.0) == 0
    wait_for(lambda: finished.last is not None and finished.last.data, what="the end")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("paused", [False, True])
def test_a_signal_ends_it_clean(simulator, ros, number, paused):
    process = simulator(loop=True, paused=paused, clock=paused, start_delay=0.0)
    wait_for(lambda: f"{NODE}" in ros.nodes(), 10.0, "the node", process)
    begin = time.monotonic()
    process.stop(number)
    took = time.monotonic() - begin
    print("ends within [s]:", round(took, 3))
    assert took < 2.0 and process.ended() == (0,)


def test_standing_by_costs_little(simulator, ros):
    process = simulator(loop=True)
    ros.listen(MultiDOFJointState, "skeleton", DEEP).wait(5)

    def used():
        words = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(words[11]) + int(words[12])) / 100.0
    begin, at = used(), time.monotonic()
    time.sleep(2.0)
    share = (used() - begin) / (time.monotonic() - at)
    print("of a core:", share, "MB:", process.memory() / 1e6)
    assert math.isfinite(share) and share < 0.5


def test_its_clock_stands_until_somebody_listens(simulator, ros):
    # Who records by simulated time listens to nobody before the time is known.
    clock = ros.listen(Clock, "/clock", DEEP)
    simulator(clock=True, clock_start=50.0, listeners=1, start_delay=0.5, tf=False)
    clock.wait(200)
    assert {nanoseconds(message.clock) for message in clock.messages} == {50 * 10**9}
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    heard.wait(10)
    assert 50.5e9 <= stamps(heard.messages)[0] < 51.5e9
    times = [nanoseconds(message.clock) for message in clock.messages]
    assert times == sorted(times)
    assert max(b - a for a, b in zip(times, times[1:])) < 0.2e9, "it goes on from where it stood"


def test_listeners_of_any_of_the_partners_topics_count(simulator, ros):
    heard = ros.listen(MarkerArray, "skeleton_markers", DEEP_RELIABLE)
    simulator(listeners=1, markers=True, start_delay=0.0)
    heard.wait(3)


def test_whoever_listens_to_all_transforms_does_not_count(simulator, ros):
    messages = pytest.importorskip("tf2_msgs.msg")
    ros.listen(messages.TFMessage, "/tf", RELIABLE)
    simulator(listeners=1, tf=True, start_delay=0.0)
    wait_for(lambda: ros.node.count_publishers("/tf"), 10.0, "its topics")
    time.sleep(0.5)
    heard = ros.listen(messages.TFMessage, "/tf", RELIABLE)
    assert heard.count == 0
    ros.listen(MultiDOFJointState, "skeleton", DEEP).wait(3)


def test_who_is_waited_for_is_said(simulator, ros):
    heard = ros.listen(MultiDOFJointState, "skeleton", DEEP)
    ros.listen(MarkerArray, "skeleton_markers", DEEP_RELIABLE)
    process = simulator(listeners=2, markers=True, tf=False, start_delay=0.0)
    # Somebody may listen to several topics: they are not added up.
    line = "waits for 2 listeners of skeleton (1 there) or skeleton_markers (1 there)"
    process.says(line, 10.0)
    assert heard.count == 0
    ros.listen(MultiDOFJointState, "skeleton", DEEP)
    heard.wait(3)
    assert process.stderr().count("waits for") == 1


def test_the_farewell_lasts_and_is_no_silence(programs, ros):
    clock = ros.publisher(Clock, "/clock", RELIABLE)
    finished = ros.listen(Bool, f"{NODE}/finished", LATCHED)
    step = itertools.count(500)

    def tick():
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(next(step) * 2 * 10**7, 10**9)
        clock.publish(message)
    ros.timer(0.005, tick)
    process = programs.start("handover_sim", "node", parameters={
        "use_sim_time": True, "exit_at_end": True, "speed": 10.0, "start_delay": 2.0})
    # Found before: the farewell is for those who are there.
    assert ros.get_parameters(NODE, "exit_at_end") == [True]
    wait_for(lambda: finished.last is not None and finished.last.data, 20.0, "the end", process)
    over = time.monotonic()
    assert ros.get_parameters(NODE, "speed") == [10.0]
    assert process.wait(5.0) == 0
    took = time.monotonic() - over
    print("farewell [s]:", round(took, 3))
    assert 0.3 < took < 2.0
