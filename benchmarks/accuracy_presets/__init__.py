"""Measures what presets of accuracy cost and reach, chooses by that, and judges predictions."""
