"""Explicit material point method."""
