"""Plugins of the tests: pytest takes them from here alone."""

pytest_plugins = ["pytester"]
