"""Stand-in: events of lifecycle nodes."""

from launch import Event


class ChangeState(Event):
    def __init__(self, *, lifecycle_node_matcher, transition_id):
        assert callable(lifecycle_node_matcher)
        # Create to active_shutdown, and destroy.
        if transition_id not in range(9):
            raise ValueError(f"{transition_id!r} is no transition")
        self.lifecycle_node_matcher, self.transition_id = lifecycle_node_matcher, transition_id
