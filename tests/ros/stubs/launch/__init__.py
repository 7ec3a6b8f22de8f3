"""Stand-in for ROS 2's `launch`, for machines without it: as much as our launch files use.

Signatures are those that Humble to Kilted have in common, keyword for keyword, so that what is
misspelt fails; of types it refuses what they refuse, as early. Nothing is started: what would be is
kept in the context.
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


def is_substitution(value):
    """Whether it is one, or several in a row and texts between."""
    parts = value if isinstance(value, (list, tuple)) else [value]
    return (all(isinstance(part, (str, Substitution)) for part in parts)
            and any(isinstance(part, Substitution) for part in parts))


def text_of(value):
    """What has to become text, if it can."""
    parts = value if isinstance(value, (list, tuple)) else [value]
    if not all(isinstance(part, (str, Substitution)) for part in parts):
        raise TypeError(f"{value!r} is no text and no substitution")
    return value


def perform(context, value):
    """Text of text, of a substitution, or of several in a row."""
    if isinstance(text_of(value), (list, tuple)):
        return "".join(perform(context, part) for part in value)
    return value if isinstance(value, str) else value.perform(context)


class Event:
    """Something that happens."""


class Condition:
    """Holds in a context, or does not."""


class Action:
    """Does something when it is visited, if its condition holds."""

    def __init__(self, *, condition=None):
        if not isinstance(condition, (Condition, type(None))):
            raise TypeError(f"{condition!r} is no condition")
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
    """Actions, as one or several."""
    entities = list(entities) if isinstance(entities, (list, tuple)) else [entities]
    for entity in entities:
        if not isinstance(entity, (Action, LaunchDescription)):
            raise TypeError(f"{entity!r} is no action")
    return entities
