"""Stand-in: handlers of events."""

from . import as_list


class EventHandler:
    def __init__(self, *, matcher=None, entities=None, handle_once=False):
        self.entities, self.handle_once = as_list(entities or []), handle_once


class _OnAction(EventHandler):
    def __init__(self, target_action, entities, **kwargs):
        # Here, since actions know handlers.
        from .actions import ExecuteProcess

        is_process = isinstance(target_action, (ExecuteProcess, type(None)))
        if not is_process and not callable(target_action):
            raise TypeError(f"{target_action!r} is no process and matches none")
        super().__init__(entities=entities, **kwargs)
        self.target_action = target_action


class OnProcessStart(_OnAction):
    def __init__(self, *, target_action=None, on_start, **kwargs):
        super().__init__(target_action, on_start, **kwargs)


class OnProcessExit(_OnAction):
    def __init__(self, *, target_action=None, on_exit, **kwargs):
        super().__init__(target_action, on_exit, **kwargs)
