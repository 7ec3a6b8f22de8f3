"""Stand-in: handlers of a lifecycle node's events."""

from launch.event_handlers import EventHandler

from .actions import LifecycleNode

STATES = {"unconfigured", "inactive", "active", "finalized", "configuring", "cleaningup",
          "shuttingdown", "activating", "deactivating", "errorprocessing"}


class OnStateTransition(EventHandler):
    def __init__(self, *, entities, target_lifecycle_node=None, transition=None, start_state=None,
                 goal_state=None, matcher=None, **kwargs):
        if not isinstance(target_lifecycle_node, (LifecycleNode, type(None))):
            raise RuntimeError("OnStateTransition requires a LifecycleNode as the target")
        assert {start_state, goal_state} <= STATES | {None}
        super().__init__(entities=entities, **kwargs)
        self.target, self.start_state, self.goal_state = (
            target_lifecycle_node, start_state, goal_state)
