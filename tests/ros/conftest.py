"""Tests of the programs on real ROS 2 topics: the processes as launch starts them, rclpy as peer.

`./test` builds the programs and runs these in a domain of their own. Fixtures: `programs` starts
processes and sees to it that they end as they should; `ros` is a peer on the topics; `work` is a
folder for the test; `recordings` are made-up handovers.
"""

import os
import pathlib
import signal
import sys

import pytest

from processes import Programs

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Where nobody chose: a test must not move the robot of the office next door.
if "ROS_DOMAIN_ID" not in os.environ:
    sys.exit("error: ROS_DOMAIN_ID is not set; ./test chooses one that nobody uses")
# Whoever tests beside this process (pytest -n 2) is not to hear it: the next domain is free as well.
worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
os.environ["ROS_DOMAIN_ID"] = str(int(os.environ["ROS_DOMAIN_ID"]) + int(worker))
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
# A shell's background job ignores interrupts, and so would all that it starts.
signal.signal(signal.SIGINT, signal.default_int_handler)


def folders_of_programs():
    """Where the programs are: HANDOVER_BINARIES, or cargo's folders."""
    if "HANDOVER_BINARIES" in os.environ:
        return [pathlib.Path(os.environ["HANDOVER_BINARIES"])]
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return [target / "debug", target / "release"]


@pytest.fixture
def work(tmp_path):
    """A folder of the test's own: output of processes, logs, files."""
    return tmp_path


@pytest.fixture
def programs(work):
    """Starts programs; in the end each has to obey SIGINT in time and leave nothing."""
    started = Programs(folders_of_programs(), work)
    yield started
    started.stop_all()


@pytest.fixture
def ros():
    """A peer on the topics, in a context of its own for each test."""
    # Here, so that tests without a peer need no rclpy.
    from peer import Peer

    peer = Peer()
    yield peer
    peer.close()


@pytest.fixture(scope="session")
def recordings(tmp_path_factory):
    """Six made-up handovers as a depth sensor sees them: a folder of CSV."""
    folder = tmp_path_factory.mktemp("recordings")
    made = Programs(folders_of_programs(), folder)
    made.run("handover_sim", "generate", "--count", 6, "--seed", 1, "--noise", "kinect", "-o",
             folder / "made")
    return folder / "made" / "measured"


@pytest.fixture(scope="session")
def model(recordings, tmp_path_factory):
    """A model of a robot giver, learned from all recordings but the third."""
    folder = tmp_path_factory.mktemp("model")
    made = Programs(folders_of_programs(), folder)
    clips = sorted(recordings.glob("*.csv"))
    del clips[2]
    path = folder / "model.safetensors"
    # One edge, between the hands, is what learning ends with; it takes longer.
    made.run("handover", "learn", *clips, "--role", "giver", "--method", "grow", "--set",
             "learn.steps=1", "--set", "learn.references=1", "-o", path)
    return path


@pytest.fixture(scope="session")
def clip(recordings):
    """The recording that the model does not know."""
    from handover import Clip

    return Clip(sorted(recordings.glob("*.csv"))[2])


@pytest.fixture
def handover(programs, model):
    """Starts a handover node that is active at once, or as told."""
    def start(parameters=None, **how):
        given = {"node.model": str(model), "node.autostart": True, **(parameters or {})}
        process = programs.start("handover_node", parameters=given, **how)
        if given["node.autostart"]:
            process.says("]: active", 30.0)
        return process
    return start
