"""Stand-in: parameters with a type."""

from launch import perform


class ParameterValue:
    def __init__(self, value, *, value_type=None):
        assert value_type in (str, int, float, bool)
        self.value, self.value_type = value, value_type

    def evaluate(self, context):
        text = perform(context, self.value)
        if self.value_type is bool:
            assert text.lower() in ("true", "false"), f"{text} is neither true nor false"
            return text.lower() == "true"
        return self.value_type(text)
