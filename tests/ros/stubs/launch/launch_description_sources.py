"""Stand-in: launch files as sources."""

import runpy

from . import LaunchDescription, perform, text_of


class PythonLaunchDescriptionSource:
    def __init__(self, launch_file_path):
        self.path = text_of(launch_file_path)

    def load(self, context):
        self.path = perform(context, self.path)
        description = runpy.run_path(self.path)["generate_launch_description"]()
        assert isinstance(description, LaunchDescription)
        return description
