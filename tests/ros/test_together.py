"""Simulator and node, as they are launched: one in place of a sensor and a robot, the other at work."""

import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import MultiDOFJointState
from std_msgs.msg import Bool, String
from trajectory_msgs.msg import MultiDOFJointTrajectory

from handover import DEEP, DEEP_RELIABLE, LATCHED, nanoseconds
from processes import wait_for


@pytest.fixture
def simulator(programs, recordings):
    """Starts the simulator with the recording that the model does not know."""
    def start(**parameters):
        path = sorted(recordings.glob("*.csv"))[2]
        given = {"recording": str(path), "role": "giver", **parameters}
        return programs.start("handover_sim", "node", parameters=given)
    return start


def test_a_killed_simulator_holds_the_robot_and_a_new_one_moves_it(handover, simulator, ros):
    handover()
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    diagnostics = ros.listen(DiagnosticArray, "/diagnostics", DEEP_RELIABLE)
    seen = ros.listen(MultiDOFJointState, "/skeleton", DEEP)
    targets = ros.listen(MultiDOFJointTrajectory, "/handover/joint_targets")
    # The node and this.
    playing = simulator(listeners=2)
    wait_for(lambda: states.last is not None and states.last.data == "approach", 20, "approach")
    playing.kill()
    killed = time.time_ns()
    wait_for(lambda: states.last.data == "hold", 2, "hold")

    def stale():
        """the reason, which is told when it changes"""
        return [nanoseconds(message.header.stamp) for message in diagnostics.messages
                if nanoseconds(message.header.stamp) > last and reason(message) == "stale"]

    def reason(message):
        return {value.key: value.value for value in message.status[0].values}["hold_reason"]
    # By the stamps of what was seen and said: this process may be late.
    last = nanoseconds(seen.last.header.stamp)
    held = wait_for(stale, 2)[0]
    print(f"held {(held - last) * 1e-6:.0f} ms after the last skeleton, "
          f"{(held - killed) * 1e-6:.0f} ms after the simulator's death")
    # filter.stale is 0.2 s; the last skeleton may be lost.
    assert 0.15e9 < held - last < 0.35e9
    wait_for(lambda: reason(diagnostics.last) == "stopped", 3, "that it has been so for long")
    assert len(targets.last.points) == 1, "it stands"
    simulator(listeners=1)
    wait_for(lambda: states.last.data not in ("hold", "idle"), 20, "a robot that moves")


def test_by_simulated_time_a_fast_play_is_the_same_play(handover, simulator, ros):
    handover({"use_sim_time": True})
    targets = ros.listen(MultiDOFJointTrajectory, "/handover/joint_targets", DEEP_RELIABLE)
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    finished = ros.listen(Bool, "/handover_sim/finished", LATCHED)

    def ticks(start):
        """Plays once from a time [s] on; how many targets there were in a simulated second."""
        targets.clear()
        finished.clear()
        playing = simulator(clock=True, clock_start=start, speed=2.0, listeners=1)
        wait_for(lambda: finished.last is not None and finished.last.data, 30, "the end")
        playing.stop()
        stamps = [nanoseconds(target.header.stamp) for target in targets.messages]
        assert min(stamps) >= start * 1e9 and stamps == sorted(stamps)
        passed = (stamps[-1] - stamps[0]) * 1e-9
        took = (targets.sent[-1] - targets.sent[0]) * 1e-9
        print(f"{len(stamps) / passed:.0f} targets a second, {passed / took:.2f} times as fast")
        assert passed > 1.5 * took, "twice as fast"
        return len(stamps) / passed
    # A hundred, where the machine has time for it.
    assert ticks(100.0) > 70 or ticks(200.0) > 70
    assert {"approach", "contact"} <= {message.data for message in states.messages}


def test_faults_of_the_sensor_do_not_stop_it(handover, simulator, ros):
    handover()
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    targets = ros.listen(MultiDOFJointTrajectory, "/handover/joint_targets", DEEP_RELIABLE)
    finished = ros.listen(Bool, "/handover_sim/finished", LATCHED)
    simulator(listeners=1, **{"sensor.kind": "kinect", "sensor.frame_loss": 0.3,
                              "sensor.hold_rate": 0.5, "sensor.hold_duration": 0.2})
    wait_for(lambda: finished.last is not None and finished.last.data, 30, "the end")
    assert targets.count > 100
    assert "approach" in {message.data for message in states.messages}


@pytest.mark.parametrize("source", ["tf", "markers"])
def test_whoever_looks_elsewhere_is_waited_for_too(handover, simulator, ros, source):
    if source == "tf":
        pytest.importorskip("tf2_msgs.msg")
    handover({"node.source": source})
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    simulator(listeners=1, **{source: True})
    wait_for(lambda: states.last is not None and states.last.data == "approach", 20, "approach")
