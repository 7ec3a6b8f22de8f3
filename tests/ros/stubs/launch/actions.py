"""Stand-in: actions."""

from . import Action, Event, LaunchContext, perform, text_of
from .event_handlers import EventHandler


class DeclareLaunchArgument(Action):
    def __init__(self, name, *, default_value=None, description=None, choices=None, **kwargs):
        super().__init__(**kwargs)
        if choices is not None and (not choices or default_value not in [None, *choices]):
            raise RuntimeError(f"{default_value!r} is none of {choices}")
        self.name = name
        self.default_value = None if default_value is None else text_of(default_value)
        self.description, self.choices = description, choices

    def execute(self, context):
        super().execute(context)
        if self.name not in context.launch_configurations:
            if self.default_value is None:
                raise RuntimeError(f'Required launch argument "{self.name}" was not provided.')
            context.launch_configurations[self.name] = perform(context, self.default_value)
        value = context.launch_configurations[self.name]
        if self.choices is not None and value not in self.choices:
            raise RuntimeError(f'Argument "{self.name}" provided value "{value}" is not valid.')


class OpaqueFunction(Action):
    def __init__(self, *, function, args=None, kwargs=None, **left):
        super().__init__(**left)
        if not callable(function):
            raise TypeError(f"{function!r} cannot be called")
        self.function, self.args, self.kwargs = function, args or [], kwargs or {}

    def execute(self, context):
        assert isinstance(context, LaunchContext)
        return self.function(context, *self.args, **self.kwargs)


class LogInfo(Action):
    def __init__(self, *, msg, **kwargs):
        super().__init__(**kwargs)
        self.msg = text_of(msg)


class EmitEvent(Action):
    def __init__(self, *, event, **kwargs):
        super().__init__(**kwargs)
        if not isinstance(event, Event):
            raise RuntimeError(f"EmitEvent() expected an event, got {event!r}")
        self.event = event


class RegisterEventHandler(Action):
    def __init__(self, event_handler, **kwargs):
        super().__init__(**kwargs)
        assert isinstance(event_handler, EventHandler)
        self.event_handler = event_handler


class ExecuteProcess(Action):
    def __init__(self, *, cmd, name=None, cwd=None, env=None, additional_env=None, shell=False,
                 output="log", sigterm_timeout="5", sigkill_timeout="5", emulate_tty=False,
                 prefix=None, respawn=False, respawn_delay=None, on_exit=None, **kwargs):
        super().__init__(**kwargs)
        self.cmd = [text_of(word) for word in cmd]
        self.name = None if name is None else text_of(name)
        self.output = text_of(output)

    def execute(self, context):
        assert self not in context.executed, "executed more than once"
        super().execute(context)
        self.words = [perform(context, word) for word in self.cmd]


class IncludeLaunchDescription(Action):
    def __init__(self, launch_description_source, *, launch_arguments=None, **kwargs):
        super().__init__(**kwargs)
        self.source = launch_description_source
        self.arguments = [(text_of(name), text_of(value))
                          for name, value in tuple(launch_arguments or ())]

    def execute(self, context):
        super().execute(context)
        description = self.source.load(context)
        declared = {entity.name for entity in description.entities
                    if isinstance(entity, DeclareLaunchArgument)}
        for name, value in self.arguments:
            # The real one lets it pass; a misspelt name would be lost.
            assert name in declared, f"{self.source.path} has no argument {name}"
            context.launch_configurations[name] = perform(context, value)
        return [description]
