"""Stand-in: conditions."""

from . import Condition, perform, text_of


class IfCondition(Condition):
    def __init__(self, predicate_expression):
        self.expression = text_of(predicate_expression)

    def evaluate(self, context):
        value = perform(context, self.expression).strip().lower()
        assert value in ("true", "false", "1", "0"), f"{value} is neither true nor false"
        return value in ("true", "1")
