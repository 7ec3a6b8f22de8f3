"""Stand-in: handlers of events."""

from . import as_list
from .actions import ExecuteProcess


class EventHandler:
    def __init__(self, *, matcher=None, entities=None, handle_once=False):
        self.entities, self.handle_once = as_list(entities), handle_once


class _OnAction(EventHandler):
    def __init__(self, target_action, entities, **kwargs):
        assert target_action is None or isinstance(target_action, ExecuteProcess)
        super().__init__(entities=entities, **kwargs)
        self.target_action = target_action


class OnProcessStart(_OnAction):
    def __init__(self, *, target_action=None, on_start, **kwargs):
        super().__init__(target_action, on_start, **kwargs)


class OnProcessExit(_OnAction):
    def __init__(self, *, target_action=None, on_exit, **kwargs):
        super().__init__(target_action, on_exit, **kwargs)
