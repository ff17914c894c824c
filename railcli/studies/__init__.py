"""Use cases, for a command and for a Python user alike: objects in, answers out; they print nothing."""
