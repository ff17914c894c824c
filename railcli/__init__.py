"""railcli: three-dimensional railway vehicle dynamics in real time, open and checkable."""

__version__ = "0.1.0"
