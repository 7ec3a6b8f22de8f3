"""Stand-in: nodes."""

from launch import perform
from launch.actions import ExecuteProcess

from .parameter_descriptions import ParameterValue


class Node(ExecuteProcess):
    def __init__(self, *, executable, package=None, name=None, namespace=None,
                 exec_name=None, parameters=None, remappings=None, ros_arguments=None,
                 arguments=None, **kwargs):
        super().__init__(cmd=[package, executable, *(arguments or [])], name=exec_name, **kwargs)
        assert isinstance(parameters or [], list), "parameters is no list"
        self.package, self.executable, self.arguments = package, executable, arguments or []
        self.node_name, self.namespace = name, namespace
        self.parameters, self.remappings = parameters or [], remappings or []
        self.ros_arguments = ros_arguments or []

    def execute(self, context):
        super().execute(context)
        assert all(isinstance(word, str) for word in self.ros_arguments)
        self.node_name = perform(context, self.node_name)
        self.namespace = perform(context, self.namespace)
        self.files, self.values = [], {}
        for entry in self.parameters:
            if not isinstance(entry, dict):
                self.files.append(perform(context, entry))
                continue
            for name, value in entry.items():
                # A bare text would be read as YAML, and might become a number.
                assert isinstance(value, ParameterValue), f"{name}: {value!r} has no type"
                self.values[name] = value.evaluate(context)
        self.remappings = [(perform(context, old), perform(context, new))
                           for old, new in self.remappings]


class LifecycleNode(Node):
    # The real one wants both, though Node does not.
    def __init__(self, *, name, namespace, **kwargs):
        super().__init__(name=name, namespace=namespace, **kwargs)
