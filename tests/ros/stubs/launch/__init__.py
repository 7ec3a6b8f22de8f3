"""Stand-in for ROS 2's `launch`, for machines without it: as much as our launch files use.

Signatures are those that Humble to Kilted have in common, keyword for keyword, so that what is
misspelt fails. Nothing is started: what would be is kept in the context.
"""


class LaunchContext:
    """Arguments by name, and what was executed in order."""

    def __init__(self, arguments=None):
        self.launch_configurations = dict(arguments or {})
        self.executed = []


class Substitution:
    """Becomes text in a context."""

    def perform(self, context):
        raise NotImplementedError


def perform(context, value):
    """Text of text, of a substitution, or of several in a row."""
    if isinstance(value, str):
        return value
    if isinstance(value, Substitution):
        return value.perform(context)
    assert isinstance(value, (list, tuple)), f"{value!r} is no text and no substitution"
    return "".join(perform(context, part) for part in value)


class Action:
    """Does something when it is visited, if its condition holds."""

    def __init__(self, *, condition=None):
        assert condition is None or hasattr(condition, "evaluate")
        self.condition = condition

    def visit(self, context):
        """What follows from it: a list of actions, or nothing."""
        if self.condition is None or self.condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context):
        context.executed.append(self)


def run(entities, context):
    """Visits all of it, in launch's order."""
    for entity in entities:
        assert isinstance(entity, (Action, LaunchDescription)), f"{entity!r} is no action"
        run(entity.visit(context) or [], context)


class LaunchDescription:
    """A list of actions."""

    def __init__(self, initial_entities=None):
        self.entities = list(initial_entities or [])

    def visit(self, context):
        return self.entities


def as_list(entities):
    return list(entities) if isinstance(entities, (list, tuple)) else [entities]
