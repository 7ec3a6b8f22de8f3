"""Stand-in: parameters with a type."""

from launch import is_substitution, perform

SCALARS = (int, float, bool, str)


class ParameterValue:
    """What is substituted is coerced, once the node starts; a value has to be of its type already."""

    def __init__(self, value, *, value_type=None):
        if value_type not in (None, *SCALARS):
            raise ValueError(f"Unrecognized data type: {value_type}")
        if not is_substitution(value) and not isinstance(value, value_type or SCALARS):
            raise TypeError(f"value='{value}' is not an instance of {value_type}")
        self.value, self.value_type = value, value_type

    def evaluate(self, context):
        if not is_substitution(self.value):
            return self.value
        text = perform(context, self.value)
        if self.value_type is bool:
            if text.lower() not in ("true", "false"):
                raise ValueError(f"Cannot convert value '{text}' to '{bool}'")
            return text.lower() == "true"
        assert self.value_type is not None, f"{text!r} would be read as YAML"
        return self.value_type(text)
