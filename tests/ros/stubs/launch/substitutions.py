"""Stand-in: substitutions."""

import os

from . import Substitution, perform, text_of


class LaunchConfiguration(Substitution):
    def __init__(self, variable_name, *, default=None):
        self.name, self.default = text_of(variable_name), default

    def perform(self, context):
        if self.name not in context.launch_configurations:
            assert self.default is not None, f"launch configuration '{self.name}' does not exist"
            return perform(context, self.default)
        return context.launch_configurations[self.name]


class PathJoinSubstitution(Substitution):
    def __init__(self, substitutions):
        self.parts = [text_of(part) for part in substitutions]

    def perform(self, context):
        return os.path.join(*(perform(context, part) for part in self.parts))


class FindExecutable(Substitution):
    def __init__(self, *, name):
        self.name = text_of(name)

    def perform(self, context):
        return f"/bin/{self.name}"
