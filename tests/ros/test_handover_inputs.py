"""Where the handover node sees its partner: frames, markers, other frames, other clocks."""

import math
import time

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TransformStamped
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import MultiDOFJointState
from visualization_msgs.msg import Marker, MarkerArray

from handover import (
    GIVER, RECEIVER, Meeting, distance, nanoseconds, place_of, skeleton, transform)
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
        super().__init__(ros, clip, listens=False)
        self.kind, self.name = kind, name
        self.tree = ros.publisher(kind, "/tf", QoSProfile(depth=100), subscribers=1)

    def show(self, frame, partner=True):
        stamp = self.ros.now()
        self.robot.publish(skeleton(self.clip.robot(frame), stamp))
        self.sent.append((time.time_ns(), nanoseconds(stamp)))
        people = self.clip.people[frame][RECEIVER]
        other = {joint: [x + 30.0, y, z] for joint, (x, y, z) in people.items()}
        edges = transforms(other, stamp, 1, name=self.name)
        edges += transforms(people, stamp, 2, name=self.name)
        self.tree.publish(self.kind(transforms=edges))


def test_a_partner_as_frames(handover, ros, clip, tf):
    handover({"node.source": "tf"})
    diagnostics = ros.listen(DiagnosticArray, "/diagnostics")
    meeting = TransformMeeting(ros, clip, tf)
    meeting.play()
    assert hand_error(meeting, clip) < 0.1
    said = {value.key: value.value for value in diagnostics.last.status[0].values}
    assert said["partner"] == "2", "whoever is nearest"


class MarkerMeeting(Meeting):
    """The receiver as markers, in the sensor's frame."""

    def __init__(self, ros, clip):
        super().__init__(ros, clip, listens=False)
        self.markers = ros.publisher(MarkerArray, "/skeleton_markers", subscribers=1)

    def show(self, frame, partner=True):
        stamp = self.ros.now()
        self.robot.publish(skeleton(self.clip.robot(frame), stamp))
        self.sent.append((time.time_ns(), nanoseconds(stamp)))
        people = as_sensor_sees(self.clip.people[frame][RECEIVER])
        self.markers.publish(markers(people, stamp, 3, "camera"))


def test_a_partner_as_markers_of_a_sensor_whose_place_is_a_parameter(handover, ros, clip):
    handover({"node.source": "markers", "node.sensor_frame": "camera",
              "node.world_from_sensor": [0.0, 0.0, HEIGHT, 0.0, 0.0, YAW]})
    meeting = MarkerMeeting(ros, clip)
    meeting.play()
    assert hand_error(meeting, clip) < 0.1


class SensorMeeting(Meeting):
    """The receiver in the frame of a sensor that the tree of frames knows."""

    def show(self, frame, partner=True):
        stamp = self.ros.now()
        self.robot.publish(skeleton(self.clip.robot(frame), stamp))
        self.sent.append((time.time_ns(), nanoseconds(stamp)))
        people = as_sensor_sees(self.clip.people[frame][RECEIVER])
        self.partner.publish(skeleton(people, stamp, "camera"))


def test_a_sensor_whose_place_the_tree_of_frames_knows(handover, ros, clip, tf):
    from peer import LATCHED

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
    meeting.play()
    assert hand_error(meeting, clip) < 0.1


def test_simulated_time_is_the_time(handover, ros, clip):
    clock = ros.publisher(Clock, "/clock", QoSProfile(depth=1))
    handover({"use_sim_time": True})
    wait_for(lambda: clock.get_subscription_count() > 0, what="the node's clock")
    meeting = Meeting(ros, clip)
    start, passed = 1000 * 10**9, 0

    def at(nanosecond):
        return Time(sec=nanosecond // 10**9, nanosec=nanosecond % 10**9)

    # Three times as fast as the wall clock, in steps of 5 ms.
    for frame, seconds in enumerate(clip.times):
        while passed < seconds * 1e9:
            passed += 5_000_000
            clock.publish(Clock(clock=at(start + passed)))
            time.sleep(0.005 / 3)
        stamp = at(start + passed)
        meeting.sent.append((time.time_ns(), start + passed))
        meeting.robot.publish(skeleton(clip.robot(frame), stamp))
        meeting.partner.publish(skeleton(clip.people[frame][RECEIVER], stamp))
    targets = meeting.targets.messages
    assert all(start <= nanoseconds(target.header.stamp) <= start + passed for target in targets)
    assert hand_error(meeting, clip) < 0.15
    # Where time stands still nothing is said.
    time.sleep(0.2)
    count = meeting.targets.count
    time.sleep(0.5)
    assert meeting.targets.count <= count + 1
    assert len(targets) > 60 * clip.times[-1], "ticks are counted in simulated time"


def test_two_robots_in_two_namespaces(handover, ros, clip):
    one = handover(namespace="/left")
    other = handover(namespace="/right", parameters={"node.rate": 50.0})
    left, right = Meeting(ros, clip, "/left"), Meeting(ros, clip, "/right")
    player = left.play_in_background()
    time.sleep(1.0)
    assert right.targets.count == 0, "nobody is seen there"
    right.begin()
    player.join()
    assert left.targets.count > right.targets.count
    assert {"/left/handover", "/right/handover"} <= ros.nodes()
    names = set(ros.topics())
    assert {"/left/skeleton", "/right/skeleton", "/left/handover/joint_targets"} <= names
    one.stop()
    right.targets.clear()
    right.play(end=30)
    assert right.targets.count > 0 and other.ended() is None


def test_remapped_topics(handover, ros, clip):
    handover(remap={"skeleton": "/tracker/body", "~/joint_targets": "/arm/wanted"},
             name="giver_robot")
    partner = ros.publisher(MultiDOFJointState, "/tracker/body", subscribers=1)
    robot = ros.publisher(MultiDOFJointState, "/robot_skeleton", subscribers=1)
    from trajectory_msgs.msg import MultiDOFJointTrajectory
    heard = ros.listen(MultiDOFJointTrajectory, "/arm/wanted")
    diagnostics = ros.listen(DiagnosticArray, "/diagnostics")
    for frame in range(20):
        robot.publish(skeleton(clip.robot(frame), ros.now()))
        partner.publish(skeleton(clip.people[frame][RECEIVER], ros.now()))
        time.sleep(0.03)
    assert heard.count > 0
    # Targets come of the robot alone: that the partner was heard is told.
    said = [{value.key: value.value for value in status.status[0].values}
            for status in diagnostics.messages]
    ages = [float(values["partner_age_s"]) for values in said if "partner_age_s" in values]
    assert ages and min(ages) < 0.2, "nobody was seen on /tracker/body"


def test_without_the_object_hands_that_meet_are_no_contact(handover, ros, clip):
    handover()
    meeting = Meeting(ros, clip)
    thing = ros.publisher(PoseStamped, "/object_pose", subscribers=1)

    def play(height):
        meeting.states.clear()
        for frame, at in enumerate(clip.times):
            begun = time.monotonic()
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
            time.sleep(max(0.0, begun + step - time.monotonic()))
        return {message.data for message in meeting.states.messages}

    assert "contact" not in play(2.0)
    assert "contact" in play(0.0)
