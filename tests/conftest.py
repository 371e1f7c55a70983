"""Plugins of the tests, which pytest takes from here alone; and no time limit for an example, however busy the machine."""

from hypothesis import settings

pytest_plugins = ["pytester"]

settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")
