"""Ceiling maps for mobile robots.

CeilingMapper builds a map from the images of a robot's upward camera, CeilingLocalizer finds a
robot on it, Map reads it, register() finds the motion between two images, and evaluate() compares
trajectories. All of them compute what the program `ceilmap` computes.

Metres, seconds and radians. Images are numpy arrays of uint8, (height, width) or BGR
(height, width, 3). A pose is a tuple (x, y, yaw) of base, the foot of the camera mast, on the map.
Errors are InputError (a ValueError) and RunError (a RuntimeError) with one line of text.
"""

from ceilmap._ceilmap import (
    CeilingLocalizer,
    CeilingMapper,
    Estimate,
    InputError,
    Map,
    MappingResult,
    Mosaic,
    Registration,
    Rig,
    RunError,
    Sensors,
    __version__,
    default_settings,
    evaluate,
    register,
)

__all__ = [
    "CeilingLocalizer",
    "CeilingMapper",
    "Estimate",
    "InputError",
    "Map",
    "MappingResult",
    "Mosaic",
    "Registration",
    "Rig",
    "RunError",
    "Sensors",
    "__version__",
    "default_settings",
    "evaluate",
    "register",
]
