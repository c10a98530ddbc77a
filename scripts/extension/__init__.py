"""Builds the add-on's zips with the core inside: python -m scripts.extension (make extension)."""
