"""Stand-in: events of lifecycle nodes."""


class ChangeState:
    def __init__(self, *, lifecycle_node_matcher, transition_id):
        assert callable(lifecycle_node_matcher)
        assert isinstance(transition_id, int)
        self.lifecycle_node_matcher, self.transition_id = lifecycle_node_matcher, transition_id
