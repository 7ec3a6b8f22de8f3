"""Stand-in: nodes."""

from launch import perform, text_of
from launch.actions import ExecuteProcess

from .parameter_descriptions import ParameterValue


def parameter_of(entry):
    """A file's path, or values by name."""
    if not isinstance(entry, dict):
        return text_of(entry)
    for name, value in entry.items():
        text_of(name)
        # The real one takes texts too, but reads what is substituted as YAML: ours say their type.
        if not isinstance(value, (ParameterValue, bool, int, float)):
            raise TypeError(f"{name}: {value!r} is no value with a type")
    return entry


class Node(ExecuteProcess):
    def __init__(self, *, executable, package=None, name=None, namespace=None,
                 exec_name=None, parameters=None, remappings=None, ros_arguments=None,
                 arguments=None, **kwargs):
        super().__init__(cmd=[package, executable, *(arguments or [])], name=exec_name, **kwargs)
        if not isinstance(parameters, (list, type(None))):
            raise TypeError("parameters is no list")
        self.package, self.executable, self.arguments = package, executable, arguments or []
        self.node_name, self.namespace = name, namespace
        self.parameters = [parameter_of(entry) for entry in parameters or []]
        self.remappings = [(text_of(old), text_of(new)) for old, new in remappings or []]
        self.ros_arguments = [text_of(word) for word in ros_arguments or []]

    def execute(self, context):
        super().execute(context)
        self.node_name = perform(context, self.node_name)
        self.namespace = perform(context, self.namespace)
        self.files, self.values = [], {}
        for entry in self.parameters:
            if not isinstance(entry, dict):
                self.files.append(perform(context, entry))
                continue
            for name, value in entry.items():
                is_typed = isinstance(value, ParameterValue)
                self.values[name] = value.evaluate(context) if is_typed else value
        self.remappings = [(perform(context, old), perform(context, new))
                           for old, new in self.remappings]


class LifecycleNode(Node):
    # The real one wants both, though Node does not.
    def __init__(self, *, name, namespace, **kwargs):
        if name is None:
            raise RuntimeError("'name' must not be None.")
        super().__init__(name=name, namespace=namespace, **kwargs)
