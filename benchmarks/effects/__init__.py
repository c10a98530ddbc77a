"""What each effect costs: the time with and without it, on a scene that needs it."""
