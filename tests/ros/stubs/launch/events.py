"""Stand-in: events."""


from . import Event


class Shutdown(Event):
    def __init__(self, *, reason="reason not given", due_to_sigint=False):
        self.reason = reason


def matches_action(action):
    return lambda other: other is action
