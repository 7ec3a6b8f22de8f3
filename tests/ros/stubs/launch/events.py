"""Stand-in: events."""


class Shutdown:
    def __init__(self, *, reason="reason not given", due_to_sigint=False):
        self.reason = reason


def matches_action(action):
    return lambda other: other is action
