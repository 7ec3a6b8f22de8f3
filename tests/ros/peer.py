"""Somebody else on the topics: rclpy in a thread of its own, with what tests ask most."""

import collections
import threading
import time

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.parameter import Parameter as Value
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from processes import wait_for

# As the node's inputs, and its targets.
SENSOR = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
# To hear all that was said, however late this process is: such a listener goes with any publisher,
# the second with reliable ones, the third with those that keep what they said for whoever comes
# later.
DEEP = QoSProfile(depth=2000, reliability=ReliabilityPolicy.BEST_EFFORT)
DEEP_RELIABLE = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)

TRANSITIONS = {
    "configure": Transition.TRANSITION_CONFIGURE,
    "cleanup": Transition.TRANSITION_CLEANUP,
    "activate": Transition.TRANSITION_ACTIVATE,
    "deactivate": Transition.TRANSITION_DEACTIVATE,
    "unconfigured_shutdown": Transition.TRANSITION_UNCONFIGURED_SHUTDOWN,
    "inactive_shutdown": Transition.TRANSITION_INACTIVE_SHUTDOWN,
    "active_shutdown": Transition.TRANSITION_ACTIVE_SHUTDOWN,
}


class Heard:
    """What came on one topic: `(sent [ns, wall clock], message)`, the oldest first.

    Sent is by the publisher, so that it says nothing of how late this process is.
    """

    def __init__(self, kept):
        self.entries = collections.deque(maxlen=kept)
        self.count = 0

    def with_information(self, message, information):
        self._keep(information["source_timestamp"] or time.time_ns(), message)

    def without(self, message):
        self._keep(time.time_ns(), message)

    def _keep(self, sent, message):
        self.entries.append((sent, message))
        self.count += 1

    @property
    def callback(self):
        """What a subscription calls: Humble's say nothing of who sent when."""
        tells = hasattr(Subscription, "CallbackType")
        return self.with_information if tells else self.without

    @property
    def sent(self):
        return [sent for sent, _ in list(self.entries)]

    @property
    def messages(self):
        return [message for _, message in list(self.entries)]

    @property
    def last(self):
        return self.entries[-1][1] if self.entries else None

    def clear(self):
        self.entries.clear()
        self.count = 0

    def wait(self, count=1, seconds=10.0):
        """Waits until that many have come since the start or `clear`; all that are kept."""
        wait_for(lambda: self.count >= count, seconds, f"{count} messages")
        return self.messages


class Peer:
    """A node of rclpy named `tester` that a thread spins: callbacks come by themselves."""

    def __init__(self, name="tester", namespace=None):
        self.context = rclpy.Context()
        # Not the process's handlers: pytest's own interrupt has to work.
        rclpy.init(args=[], context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node(name, namespace=namespace, context=self.context,
                                      start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._clients = {}
        self._closing = False
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _spin(self):
        try:
            while not self._closing:
                self._executor.spin_once(timeout_sec=0.1)
        except ExternalShutdownException:
            pass

    def close(self):
        # First the thread: an executor that is shut down while it calls back fails there.
        self._closing = True
        self._executor.wake()
        self._thread.join(5.0)
        self._executor.shutdown(timeout_sec=5.0)
        rclpy.try_shutdown(context=self.context)
        self.node.destroy_node()

    def listen(self, kind, topic, qos=RELIABLE, kept=100_000):
        """Hears a topic from now on."""
        heard = Heard(kept)
        self.node.create_subscription(kind, topic, heard.callback, qos)
        return heard

    def publisher(self, kind, topic, qos=SENSOR, subscribers=0, seconds=10.0):
        """A publisher, once as many as `subscribers` have found it."""
        publisher = self.node.create_publisher(kind, topic, qos)
        wait_for(lambda: publisher.get_subscription_count() >= subscribers, seconds,
                 f"{subscribers} subscribers of {topic}")
        return publisher

    def timer(self, period, callback):
        """Calls back every `period` [s], in the peer's thread."""
        return self.node.create_timer(period, callback)

    def now(self):
        """The wall clock's time as a message has it."""
        return self.node.get_clock().now().to_msg()

    def call(self, kind, name, request=None, seconds=10.0):
        """Calls a service, once it is there; its answer."""
        client = self._clients.get((kind, name))
        if client is None:
            client = self._clients[kind, name] = self.node.create_client(kind, name)
        wait_for(client.service_is_ready, seconds, f"service {name}")
        answer = client.call_async(request if request is not None else kind.Request())
        wait_for(answer.done, seconds, f"an answer of {name}")
        return answer.result()

    def topics(self):
        """Every topic that anybody has: name → types."""
        return dict(self.node.get_topic_names_and_types())

    def nodes(self):
        """Every node's full name."""
        pairs = self.node.get_node_names_and_namespaces()
        return {f"{space.rstrip('/')}/{name}" for name, space in pairs}

    def state(self, node):
        """The label of a lifecycle node's state: unconfigured, inactive, active, finalized."""
        return self.call(GetState, f"{node}/get_state").current_state.label

    def change_state(self, node, transition, seconds=30.0):
        """Asks for a transition by its label; whether it succeeded."""
        request = ChangeState.Request()
        request.transition.id = TRANSITIONS[transition]
        return self.call(ChangeState, f"{node}/change_state", request, seconds).success

    def get_parameters(self, node, *names):
        """Values by name, in the order asked; None where a parameter is not set."""
        request = GetParameters.Request(names=list(names))
        answer = self.call(GetParameters, f"{node}/get_parameters", request)
        return [parameter_value_to_python(value) for value in answer.values]

    def set_parameters(self, node, **values):
        """Sets parameters, `__` in a name meaning a dot: name → (taken, the reason if not)."""
        names = [name.replace("__", ".") for name in values]
        wanted = [Parameter(name=name, value=Value(name, value=value).get_parameter_value())
                  for name, value in zip(names, values.values(), strict=True)]
        request = SetParameters.Request(parameters=wanted)
        answer = self.call(SetParameters, f"{node}/set_parameters", request)
        return {name: (result.successful, result.reason)
                for name, result in zip(names, answer.results, strict=True)}
