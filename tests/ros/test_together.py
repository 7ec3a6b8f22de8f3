"""Simulator and node, as they are launched: one in place of a sensor and a robot, the other at work."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool, String
from trajectory_msgs.msg import MultiDOFJointTrajectory

from handover import DEEP_RELIABLE, LATCHED, hold_of_the_unseen, median_step, nanoseconds, statuses
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
    # Every tick tells how it is doing.
    handover({"node.diagnostics_rate": 1000.0})
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    diagnostics = ros.listen(DiagnosticArray, "/diagnostics", DEEP_RELIABLE)
    targets = ros.listen(MultiDOFJointTrajectory, "/handover/joint_targets")
    playing = simulator(listeners=1)
    wait_for(lambda: states.last is not None and states.last.data == "approach", 20, "approach")
    playing.kill()
    killed = nanoseconds(ros.now())

    def is_stopped():
        """hold, and for so long that it is told"""
        told = statuses(diagnostics, killed)
        return told and told[-1]["hold_reason"] == "stopped"
    wait_for(is_stopped)
    assert states.last.data == "hold"
    # filter.stale is 0.2 s; on a busy machine ticks are late, but none goes on after that.
    went_on, held, reason = hold_of_the_unseen(statuses(diagnostics))
    print(f"went on at {went_on:.3f} s, held at {held:.3f} s")
    assert went_on <= 0.2 < held and reason == "stale"
    assert len(targets.last.points) == 1, "it stands"
    simulator(listeners=1)
    wait_for(lambda: states.last.data not in ("hold", "idle"), 20, "a robot that moves")


def test_by_simulated_time_a_fast_play_is_the_same_play(handover, simulator, ros):
    handover({"use_sim_time": True})
    targets = ros.listen(MultiDOFJointTrajectory, "/handover/joint_targets", DEEP_RELIABLE)
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    finished = ros.listen(Bool, "/handover_sim/finished", LATCHED)
    playing = simulator(clock=True, clock_start=100.0, speed=2.0, listeners=1)
    wait_for(lambda: finished.last is not None and finished.last.data, 30, "the end")
    playing.stop()
    heard = list(targets.entries)
    stamps = [nanoseconds(target.header.stamp) for _, target in heard]
    assert min(stamps) >= 100e9 and stamps == sorted(stamps)
    passed, took = (stamps[-1] - stamps[0]) * 1e-9, (heard[-1][0] - heard[0][0]) * 1e-9
    step = median_step([target for _, target in heard])
    print(f"{1e3 * step:.2f} ms between targets, {passed / took:.2f} times as fast")
    assert passed > 1.5 * took, "twice as fast"
    # Ten; twenty, were ticks counted by the wall clock.
    assert step < 15e-3
    assert {"approach", "contact"} <= {message.data for message in states.messages}


def test_faults_of_the_sensor_do_not_stop_it(handover, simulator, ros):
    handover()
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    targets = ros.listen(MultiDOFJointTrajectory, "/handover/joint_targets", DEEP_RELIABLE)
    finished = ros.listen(Bool, "/handover_sim/finished", LATCHED)
    simulator(listeners=1, **{"sensor.kind": "kinect", "sensor.frame_loss": 0.3,
                              "sensor.hold_rate": 0.5, "sensor.hold_duration": 0.2})
    wait_for(lambda: finished.last is not None and finished.last.data, 30, "the end")
    targets.wait(100)
    assert "approach" in {message.data for message in states.messages}


@pytest.mark.parametrize("source", ["tf", "markers"])
def test_whoever_looks_elsewhere_is_waited_for_too(handover, simulator, ros, source):
    if source == "tf":
        pytest.importorskip("tf2_msgs.msg")
    handover({"node.source": source})
    states = ros.listen(String, "/handover/handover_state", LATCHED)
    simulator(listeners=1, skeleton=False, **{source: True})
    wait_for(lambda: states.last is not None and states.last.data == "approach", 20, "approach")
