"""Where the handover node sees its partner: frames, markers, other frames, other clocks."""

import math
import time

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TransformStamped
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from visualization_msgs.msg import Marker, MarkerArray

from handover import (
    GIVER, LATCHED, RECEIVER, Meeting, distance, median_step, nanoseconds, place_of, skeleton,
    transform)
from processes import wait_for

# Azure Kinect's numbers of the joints that NiTE has.
AZURE = {"head": 26, "neck": 3, "torso": 1, "left_shoulder": 5, "left_elbow": 6, "left_hand": 8,
         "right_shoulder": 12, "right_elbow": 13, "right_hand": 15, "left_hip": 18,
         "left_knee": 19, "left_foot": 21, "right_hip": 22, "right_knee": 23, "right_foot": 25}
# The sensor hangs two metres up, turned by 0.5 rad about the vertical.
HEIGHT, YAW = 2.0, 0.5


def seen_by_sensor(place):
    """A place [m] as the sensor has it."""
    cosine, sine = math.cos(YAW), math.sin(YAW)
    x, y, z = place
    return [cosine * x + sine * y, cosine * y - sine * x, z - HEIGHT]


def as_sensor_sees(joints):
    return {joint: seen_by_sensor(place) for joint, place in joints.items()}


def transforms(joints, stamp, number, frame="world", name="{joint}_{number}"):
    """A frame for each joint, as NiTE's trackers send them."""
    edges = []
    for joint, place in joints.items():
        edge = TransformStamped(child_frame_id=name.format(joint=joint, number=number))
        edge.header.stamp, edge.header.frame_id = stamp, frame
        edge.transform = transform(place)
        edges.append(edge)
    return edges


def markers(joints, stamp, number, frame="world"):
    """A ball for each joint, as Azure Kinect's tracker sends them."""
    message = MarkerArray()
    for joint, place in joints.items():
        marker = Marker(id=100 * number + AZURE[joint], type=Marker.SPHERE)
        marker.header.stamp, marker.header.frame_id = stamp, frame
        marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = place
        message.markers.append(marker)
    return message


def hand_error(meeting, clip):
    """How far the robot's right hand is at contact from the human giver's [m]."""
    frame = clip.closest()
    stamp = meeting.sent[frame][1]
    near = min(meeting.targets.messages,
               key=lambda target: abs(nanoseconds(target.header.stamp) - stamp))
    errors = [distance(place_of(near, side), clip.people[frame][GIVER][side])
              for side in ("left_hand", "right_hand")]
    return min(errors)


@pytest.fixture
def tf():
    """Messages of the tree of frames; where ROS has none, the test cannot be."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        pytest.skip("no tf2_msgs in this ROS")
    return TFMessage


class TransformMeeting(Meeting):
    """The receiver as frames; a second body stands far away."""

    def __init__(self, ros, clip, kind, name="{joint}_{number}"):
        super().__init__(ros, clip, kind=kind, topic="/tf", quality=QoSProfile(depth=100))
        self.kind, self.name = kind, name

    def seen(self, frame, stamp):
        people = self.clip.people[frame][RECEIVER]
        other = {joint: [x + 30.0, y, z] for joint, (x, y, z) in people.items()}
        edges = transforms(other, stamp, 1, name=self.name)
        edges += transforms(people, stamp, 2, name=self.name)
        return self.kind(transforms=edges)


def test_a_partner_as_frames(handover, ros, clip, tf):
    handover({"node.source": "tf"})
    meeting = TransformMeeting(ros, clip, tf)
    meeting.begin()
    meeting.play()
    meeting.catch_up()
    assert hand_error(meeting, clip) < 0.1
    partners = {status["partner"] for status in meeting.statuses() if "partner" in status}
    assert partners == {"2"}, "whoever is nearest"


class MarkerMeeting(Meeting):
    """The receiver as markers, in the sensor's frame."""

    def __init__(self, ros, clip):
        super().__init__(ros, clip, kind=MarkerArray, topic="/skeleton_markers")

    def seen(self, frame, stamp):
        people = as_sensor_sees(self.clip.people[frame][RECEIVER])
        return markers(people, stamp, 3, "camera")


def test_a_partner_as_markers_of_a_sensor_whose_place_is_a_parameter(handover, ros, clip):
    handover({"node.source": "markers", "node.sensor_frame": "camera",
              "node.world_from_sensor": [0.0, 0.0, HEIGHT, 0.0, 0.0, YAW]})
    meeting = MarkerMeeting(ros, clip)
    meeting.begin()
    meeting.play()
    meeting.catch_up()
    assert hand_error(meeting, clip) < 0.1


class SensorMeeting(Meeting):
    """The receiver in the frame of a sensor that the tree of frames knows."""

    def seen(self, frame, stamp):
        return skeleton(as_sensor_sees(self.clip.people[frame][RECEIVER]), stamp, "camera")


def test_a_sensor_whose_place_the_tree_of_frames_knows(handover, ros, clip, tf):
    handover()
    fixed = ros.publisher(tf, "/tf_static", LATCHED, subscribers=1)
    edge = TransformStamped(child_frame_id="camera")
    edge.header.frame_id = "world"
    edge.transform.translation.z = HEIGHT
    edge.transform.rotation.z, edge.transform.rotation.w = math.sin(YAW / 2), math.cos(YAW / 2)
    fixed.publish(tf(transforms=[edge]))
    time.sleep(0.3)
    # What moves must not crowd out what was said once, nor may a new life forget it.
    moving = ros.publisher(tf, "/tf", QoSProfile(depth=100), subscribers=1)
    for number in range(300):
        moving.publish(tf(transforms=transforms({"wheel": [0, 0, 0]}, ros.now(), number)))
    assert ros.change_state("/handover", "deactivate")
    assert ros.change_state("/handover", "activate")
    meeting = SensorMeeting(ros, clip)
    meeting.begin()
    meeting.play()
    meeting.catch_up()
    assert hand_error(meeting, clip) < 0.1


class SimulatedMeeting(Meeting):
    """One that is the time as well, which goes on by 5 ms whenever somebody asks for it."""

    START = 1000 * 10**9

    def __init__(self, ros, clip):
        self.clock = ros.publisher(Clock, "/clock", QoSProfile(depth=1), subscribers=1)
        self.time = self.START
        super().__init__(ros, clip)

    def now(self):
        self.time += 5_000_000
        now = Time(sec=self.time // 10**9, nanosec=self.time % 10**9)
        self.clock.publish(Clock(clock=now))
        return now

    def play(self):
        """Three times as fast as the wall clock, at most."""
        begun = self.time
        for frame, seconds in enumerate(self.clip.times):
            while self.time < begun + seconds * 1e9:
                self.now()
                time.sleep(0.005 / 3)
            self.show(frame)


def test_simulated_time_is_the_time(handover, ros, clip):
    handover({"use_sim_time": True})
    meeting = SimulatedMeeting(ros, clip)
    meeting.begin()
    meeting.play()

    def is_quiet():
        """no more targets, as time stands still"""
        count = meeting.targets.count
        time.sleep(0.5)
        return meeting.targets.count == count
    wait_for(is_quiet)
    targets = meeting.targets.messages
    assert all(meeting.START <= nanoseconds(target.header.stamp) <= meeting.time
               for target in targets)
    step = median_step(targets)
    print(f"{1e3 * step:.2f} ms between targets")
    # Ten; thirty, were ticks counted by the wall clock.
    assert step < 15e-3, "ticks are counted in simulated time"
    assert hand_error(meeting, clip) < 0.15


def test_two_robots_in_two_namespaces(handover, ros, clip):
    one = handover(namespace="/left")
    other = handover(namespace="/right", parameters={"node.rate": 50.0})
    left, right = Meeting(ros, clip, "/left"), Meeting(ros, clip, "/right")
    left.begin()
    player = left.play_in_background()
    time.sleep(1.0)
    begun = nanoseconds(ros.now())
    right.begin()
    assert not [target for target in right.targets.messages
                if nanoseconds(target.header.stamp) < begun], "nobody is seen there"
    player.join()
    left.catch_up()
    right.catch_up()
    steps = [median_step(meeting.targets.messages) for meeting in (left, right)]
    print(f"{1e3 * steps[0]:.1f} and {1e3 * steps[1]:.1f} ms between targets")
    assert steps[0] < 12e-3 < steps[1]
    wait_for(lambda: {"/left/handover", "/right/handover"} <= ros.nodes(), what="both names")
    names = set(ros.topics())
    assert {"/left/skeleton", "/right/skeleton", "/left/handover/joint_targets"} <= names
    one.stop()
    right.begin()
    assert other.ended() is None


def test_remapped_topics(handover, ros, clip):
    handover(remap={"skeleton": "/tracker/body", "~/joint_targets": "/arm/wanted"},
             name="giver_robot")
    meeting = Meeting(ros, clip, node="giver_robot", topic="/tracker/body", targets="/arm/wanted")
    meeting.begin()


def test_without_the_object_hands_that_meet_are_no_contact(handover, ros, clip):
    # Every tick tells its state.
    handover({"node.diagnostics_rate": 1000.0})
    # First: who is discovered in turn, is known to the node before the partner is.
    thing = ros.publisher(PoseStamped, "/object_pose", subscribers=1)
    meeting = Meeting(ros, clip)
    meeting.begin()

    def play(height):
        begun = nanoseconds(ros.now())
        for frame, at in enumerate(clip.times):
            begins = time.monotonic()
            pose = PoseStamped()
            pose.header.stamp, pose.header.frame_id = ros.now(), "world"
            hand = min((clip.people[frame][GIVER][side] for side in ("left_hand", "right_hand")),
                       key=lambda place: distance(
                           place, clip.people[frame][RECEIVER]["torso"]))
            pose.pose.position.x, pose.pose.position.y = hand[0], hand[1]
            pose.pose.position.z = hand[2] + height
            thing.publish(pose)
            meeting.show(frame)
            step = clip.times[frame + 1] - at if frame + 1 < len(clip.times) else 0.0
            time.sleep(max(0.0, begins + step - time.monotonic()))
        meeting.catch_up()
        return {status["state"] for status in meeting.statuses(begun)}

    assert "contact" not in play(2.0)
    assert "contact" in play(0.0)
