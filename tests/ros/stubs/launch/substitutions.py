"""Stand-in: substitutions."""

import os

from . import Substitution, perform


class LaunchConfiguration(Substitution):
    def __init__(self, variable_name, *, default=None):
        self.name, self.default = variable_name, default

    def perform(self, context):
        if self.name not in context.launch_configurations:
            assert self.default is not None, f"launch configuration '{self.name}' does not exist"
            return perform(context, self.default)
        return context.launch_configurations[self.name]


class PathJoinSubstitution(Substitution):
    def __init__(self, substitutions):
        self.parts = list(substitutions)

    def perform(self, context):
        return os.path.join(*(perform(context, part) for part in self.parts))


class FindExecutable(Substitution):
    def __init__(self, *, name):
        self.name = name

    def perform(self, context):
        return f"/bin/{self.name}"
