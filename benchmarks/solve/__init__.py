"""Solves recorded, measured, simulated and composed signatures, and says how well."""
