"""The helpers themselves: they catch what they are there to catch."""

import re
import signal
import sys

import pytest
from std_msgs.msg import String
from std_srvs.srv import Trigger

from processes import Programs, held_by, shared_memory, wait_for

TALKER = """
import sys, rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import String
from std_srvs.srv import Trigger
rclpy.init(args=sys.argv)
node = rclpy.create_node("talker")
said = node.create_publisher(String, "~/said", 1)
node.create_timer(0.02, lambda: said.publish(String(data="hello")))
def answer(request, response):
    response.success = True
    return response
node.create_service(Trigger, "~/reset", answer)
node.declare_parameter("volume", 1.0)
def talk():
    print("talks", file=sys.stderr, flush=True)
    rclpy.spin(node)
try:
    talk()
except (KeyboardInterrupt, ExternalShutdownException):
    pass
node.destroy_node()
rclpy.try_shutdown()
"""


@pytest.fixture
def script(work):
    """Makes a program of Python text."""
    def make(name, text):
        path = work / name
        path.write_text(f"#!{sys.executable}\n{text}")
        path.chmod(0o755)
        return path
    # A path with a space makes no working first line of a script.
    if " " in sys.executable:
        pytest.skip("no script can name this Python")
    return make


@pytest.fixture
def scripts(work):
    started = Programs([work], work)
    yield started
    started.stop_all()


def test_a_node_is_heard_asked_and_stopped(script, scripts, ros):
    script("talk", TALKER)
    process = scripts.start("talk", name="other", namespace="/left", parameters={"volume": 0.5},
                            remap={"~/said": "/elsewhere"})
    process.says("talks")
    heard = ros.listen(String, "/elsewhere")
    assert heard.wait(3)[0].data == "hello"
    wait_for(lambda: "/left/other" in ros.nodes(), what="its name in the graph")
    assert ros.call(Trigger, "/left/other/reset").success
    assert ros.get_parameters("/left/other", "volume") == [0.5]
    assert ros.set_parameters("/left/other", volume=0.25) == {"volume": (True, "")}
    assert ros.set_parameters("/left/other", volume="loud")["volume"][0] is False
    assert process.memory() > 1e6
    process.stop()
    assert process.ended() == (0,)


def test_what_ignores_an_interrupt_fails(script, scripts):
    script("stays", "import signal, sys, time\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
                    "print('deaf', file=sys.stderr, flush=True)\ntime.sleep(60)\n")
    process = scripts.start("stays")
    process.says("deaf")
    with pytest.raises(AssertionError, match="goes on 0.2 s after signal 2"):
        process.stop(seconds=0.2)
    assert process.ended() == (-signal.SIGKILL,)


def test_what_ends_with_a_code_or_a_child_fails(script, scripts):
    # Whoever hears that it is up may interrupt it at once.
    script("crashes", "import sys, time\ntry:\n    print('up', file=sys.stderr, flush=True)\n"
                      "    time.sleep(60)\nexcept KeyboardInterrupt:\n    sys.exit(3)\n")
    process = scripts.start("crashes")
    process.says("up")
    with pytest.raises(AssertionError, match="ended with 3"):
        process.stop()
    script("leaves", "import subprocess, sys, time\n"
                     "subprocess.Popen(['sh', '-c', 'trap : INT; sleep 60; sleep 60'])\n"
                     "try:\n    time.sleep(0.2)\n    print('up', file=sys.stderr, flush=True)\n"
                     "    time.sleep(60)\nexcept KeyboardInterrupt:\n    pass\n")
    process = scripts.start("leaves")
    process.says("up")
    with pytest.raises(AssertionError, match="left a process behind"):
        process.stop()


def test_shared_memory_that_is_left_fails(script, scripts):
    # Who ends without a word to the middleware leaves its files.
    script("drops", TALKER.replace("    talk()", """
    try:
        talk()
    except (KeyboardInterrupt, ExternalShutdownException):
        import os
        os._exit(0)
""").replace("rclpy.init(args=sys.argv)", """from rclpy.signals import SignalHandlerOptions
rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)"""))
    process = scripts.start("drops")
    process.says("talks")
    with pytest.raises(AssertionError, match="left in shared memory"):
        process.stop()


def test_a_killed_node_leaves_nothing_here(script, scripts):
    script("talk", TALKER)
    process = scripts.start("talk")
    process.says("talks")
    # Ports are shared with whoever else is there; its own segment is nobody else's.
    segment = re.compile(r"fastdds_[0-9a-f]{16}")
    held = {path for path in held_by(process.pid) if segment.search(path)}
    process.kill()
    assert process.ended() == (-signal.SIGKILL,)
    assert held and not held & shared_memory()


def test_waiting_says_for_what():
    with pytest.raises(AssertionError, match="after 0.1 s still not: rain"):
        wait_for(lambda: False, 0.1, "rain")
