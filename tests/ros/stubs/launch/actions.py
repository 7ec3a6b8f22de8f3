"""Stand-in: actions."""

from . import Action, LaunchContext, Substitution, perform


class DeclareLaunchArgument(Action):
    def __init__(self, name, *, default_value=None, description=None, choices=None, **kwargs):
        super().__init__(**kwargs)
        assert choices is None or choices, "an empty list of choices"
        if choices is not None and isinstance(default_value, str):
            assert default_value in choices, f"{default_value} is none of {choices}"
        self.name, self.default_value = name, default_value
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
        self.function, self.args, self.kwargs = function, args or [], kwargs or {}

    def execute(self, context):
        assert isinstance(context, LaunchContext)
        return self.function(context, *self.args, **self.kwargs)


class LogInfo(Action):
    def __init__(self, *, msg, **kwargs):
        super().__init__(**kwargs)
        self.msg = msg


class EmitEvent(Action):
    def __init__(self, *, event, **kwargs):
        super().__init__(**kwargs)
        self.event = event


class RegisterEventHandler(Action):
    def __init__(self, event_handler, **kwargs):
        super().__init__(**kwargs)
        self.event_handler = event_handler


class ExecuteProcess(Action):
    def __init__(self, *, cmd, name=None, cwd=None, env=None, additional_env=None, shell=False,
                 output="log", sigterm_timeout="5", sigkill_timeout="5", emulate_tty=False,
                 prefix=None, respawn=False, respawn_delay=None, on_exit=None, **kwargs):
        super().__init__(**kwargs)
        self.cmd, self.name, self.output = cmd, name, output

    def execute(self, context):
        assert self not in context.executed, "executed more than once"
        super().execute(context)
        self.words = [perform(context, word) for word in self.cmd]


class IncludeLaunchDescription(Action):
    def __init__(self, launch_description_source, *, launch_arguments=None, **kwargs):
        super().__init__(**kwargs)
        self.source, self.arguments = launch_description_source, list(launch_arguments or ())

    def execute(self, context):
        super().execute(context)
        description = self.source.load(context)
        declared = {entity.name for entity in description.entities
                    if isinstance(entity, DeclareLaunchArgument)}
        for name, value in self.arguments:
            # The real one lets it pass; a misspelt name would be lost.
            assert name in declared, f"{self.source.path} has no argument {name}"
            assert isinstance(value, (str, Substitution)), f"{name}: {value!r}"
            context.launch_configurations[name] = perform(context, value)
        return [description]


