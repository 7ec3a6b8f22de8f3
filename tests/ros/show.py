"""A handover over real topics: the simulator plays a recording, the node answers, all is checked.

    show.py MODEL RECORDING ROLE OUT

Called by `./run`. Checks the targets (how many, how fast, how near the partner's hand the robot's
comes), records them with all that the node hears as a bag OUT/ros_bag, and sums it up on stdout.
"""

import ctypes
import math
import pathlib
import shutil
import signal
import sys
import tempfile
import time

import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import MultiDOFJointState
from std_msgs.msg import String
from trajectory_msgs.msg import MultiDOFJointTrajectory

from conftest import folders_of_programs
from peer import Peer
from processes import Programs, wait_for

# How near [m] the two hands that hand over have to come, and by how much a difference of rounded
# places over rounded stamps may be above the limit of speed.
NEAR = 0.3
SPEED_SLACK = 1.05

TOPICS = {
    "/skeleton": (MultiDOFJointState, ReliabilityPolicy.BEST_EFFORT),
    "/robot_skeleton": (MultiDOFJointState, ReliabilityPolicy.BEST_EFFORT),
    "/object_pose": (PoseStamped, ReliabilityPolicy.BEST_EFFORT),
    "/handover/joint_targets": (MultiDOFJointTrajectory, ReliabilityPolicy.RELIABLE),
    "/handover/hand_target": (PoseStamped, ReliabilityPolicy.RELIABLE),
    "/handover/handover_state": (String, ReliabilityPolicy.RELIABLE),
    "/diagnostics": (DiagnosticArray, ReliabilityPolicy.RELIABLE),
}


class Recorder:
    """Hears topics as bytes and keeps them: they are what a bag has."""

    def __init__(self, peer):
        self.heard = []
        for topic, (kind, reliability) in TOPICS.items():
            # Deep, so that a busy machine loses nothing of the bag.
            qos = QoSProfile(depth=100, reliability=reliability)
            peer.node.create_subscription(kind, topic, self._of(topic), qos, raw=True)

    def _of(self, topic):
        def keep(data):
            self.heard.append((time.time_ns(), topic, bytes(data)))
        return keep

    def messages(self, topic):
        return [deserialize_message(data, TOPICS[topic][0])
                for _, name, data in list(self.heard) if name == topic]

    def count(self, topic):
        return sum(name == topic for _, name, _ in list(self.heard))

    def write(self, folder):
        """Writes all of it as a bag of ROS 2, stored as MCAP, in the version that Humble reads too."""
        types = get_typestore(Stores.ROS2_JAZZY)
        with Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP) as bag:
            connections = {}
            for stamp, topic, data in self.heard:
                if topic not in connections:
                    kind = TOPICS[topic][0]
                    name = f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}"
                    connections[topic] = bag.add_connection(topic, name, typestore=types)
                bag.write(connections[topic], stamp, data)


def seconds(time_or_duration):
    return time_or_duration.sec + 1e-9 * time_or_duration.nanosec


def places(names, transforms):
    """Joints' places [m] by name; those that are not tracked are left out."""
    found = {}
    for name, transform in zip(names, transforms, strict=True):
        at = transform.translation
        if all(map(math.isfinite, (at.x, at.y, at.z))):
            found[name] = (at.x, at.y, at.z)
    return found


def target(message):
    """When a target is for [s] and where the robot's joints are to be then."""
    first = message.points[0]
    stamp = seconds(message.header.stamp) + seconds(first.time_from_start)
    return stamp, places(message.joint_names, first.transforms)


def fastest(targets):
    """The greatest speed [m/s] of any joint from one target to the next."""
    speed = 0.0
    for (before, old), (after, new) in zip(targets, targets[1:], strict=False):
        if after <= before:
            raise AssertionError(f"targets at {before} s and then at {after} s")
        for name in old.keys() & new.keys():
            speed = max(speed, math.dist(old[name], new[name]) / (after - before))
    return speed


def nearest(targets, skeletons):
    """How near [m] a hand of the robot comes to one of the partner's, at the same time."""
    least, at = math.inf, 0
    for stamp, joints in targets:
        while at + 1 < len(skeletons) and skeletons[at + 1][0] <= stamp:
            at += 1
        partner = skeletons[at][1]
        for ours in ("left_hand", "right_hand"):
            for theirs in ("left_hand", "right_hand"):
                if ours in joints and theirs in partner:
                    least = min(least, math.dist(joints[ours], partner[theirs]))
    return least


def play(model, recording, role, work):
    """Lets simulator and node talk until the recording has ended; what was heard."""
    programs = Programs(folders_of_programs(), work)
    peer = Peer("show")
    try:
        recorder = Recorder(peer)
        programs.start("handover_node", name="handover", params_file=CONFIG,
                       parameters={"node.model": str(model), "node.role": role})
        wait_for(lambda: peer.state("/handover") == "unconfigured", 10, "the node's state")
        for transition in ("configure", "activate"):
            if not peer.change_state("/handover", transition):
                raise AssertionError(f"the node did not {transition}")
        simulator = programs.start("handover_sim", "node", name="handover_sim",
                                   parameters={"recording": str(recording), "role": role,
                                               # The node and the recorder.
                                               "listeners": 2})
        wait_for(lambda: recorder.count("/skeleton") > 0, 10, "a skeleton", simulator)
        # Its end is that nobody is seen any more, be the simulator still there or not.
        seen = {"count": 0, "at": time.monotonic()}

        def over():
            count = recorder.count("/skeleton")
            if count != seen["count"]:
                seen.update(count=count, at=time.monotonic())
            return time.monotonic() - seen["at"] > 1.0
        wait_for(over, 120, "the recording's end")
        programs.stop_all()
        return recorder
    finally:
        programs.end_all()
        peer.close()


CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config" / "handover.yaml"


def main(model, recording, role, out):
    """Plays, checks, records and says how it went; 0, or 1 with the reason."""
    out = pathlib.Path(out).resolve()
    parameters = yaml.safe_load(CONFIG.read_text())["/**"]["ros__parameters"]
    limit, rate = parameters["safety"]["speed"], parameters["tick"]["rate"]
    rate = parameters.get("node", {}).get("rate", rate)
    with tempfile.TemporaryDirectory(prefix="handover_") as work:
        recorder = play(pathlib.Path(model).resolve(), pathlib.Path(recording).resolve(), role,
                        pathlib.Path(work))

    skeletons = [(seconds(message.header.stamp), places(message.joint_names, message.transforms))
                 for message in recorder.messages("/skeleton")]
    targets = [target(message) for message in recorder.messages("/handover/joint_targets")]
    lasted = skeletons[-1][0] - skeletons[0][0]
    # Ours, before any check: what failed is to be looked at.
    bag = out / "ros_bag"
    shutil.rmtree(bag, ignore_errors=True)
    recorder.write(bag)

    wanted = int(0.8 * lasted * rate)
    speed = fastest(targets)
    gap = nearest(targets, skeletons)
    print(f"skeletons       {len(skeletons)} in {lasted:.1f} s")
    print(f"targets         {len(targets)} (at least {wanted})")
    print(f"fastest joint   {speed:.2f} m/s (at most {limit} m/s)")
    print(f"nearest hands   {100 * gap:.1f} cm (at most {100 * NEAR:.0f} cm)")
    states = [message.data for message in recorder.messages("/handover/handover_state")]
    if states:
        print(f"states          {' '.join(dict.fromkeys(states))}")
    print(f"bag             {bag}")
    failures = []
    if len(targets) < wanted:
        failures.append(f"{len(targets)} targets, not {wanted}")
    if speed > SPEED_SLACK * limit:
        failures.append(f"a joint's target moves at {speed:.2f} m/s")
    if not gap <= NEAR:
        failures.append(f"the hands come no nearer than {100 * gap:.1f} cm")
    for failure in failures:
        print(f"error: {failure}", file=sys.stderr)
    return 1 if failures else 0


def end_with_the_caller():
    """Ends everything, in order, where this is terminated or the script that called it dies."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGTERM)


if __name__ == "__main__":
    end_with_the_caller()
    if len(sys.argv) != 5:
        sys.exit("usage: show.py MODEL RECORDING ROLE OUT")
    try:
        sys.exit(main(*sys.argv[1:]))
    except AssertionError as failure:
        sys.exit(f"error: {failure}")
