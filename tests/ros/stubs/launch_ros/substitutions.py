"""Stand-in: where a package is installed. Here the sources are, laid out as installed."""

import os

from launch import Substitution


class FindPackageShare(Substitution):
    def __init__(self, package):
        assert package == "handover_mesh"

    def perform(self, context):
        return os.environ["HANDOVER_SHARE"]
