"""Rigid-body engines side by side: what a simulation costs, and how far off it is."""
