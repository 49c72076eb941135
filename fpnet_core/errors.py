# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors that a user can act on.

Each message states what was wrong, what was expected, what was found and what to do. The command
line prints it in one line and exits with 1; a node logs it and keeps its state.
"""


class FpnetError(Exception):
    """Base of every error this package raises on bad input."""


class ConfigError(FpnetError):
    """A configuration file or value is unknown, malformed or out of range."""


class MapFormatError(FpnetError):
    """A floorplan, occupancy grid or map image cannot be used."""


class CloudFormatError(FpnetError):
    """A point cloud, laser log or scan folder cannot be used."""


class BagFormatError(FpnetError):
    """A recording is missing, corrupt, or lacks the topics that are needed."""


class OdometryError(FpnetError):
    """A sensor pose is not a rigid transform, or its time stamp goes backwards."""


class HintError(FpnetError):
    """A hint about the pose or the storey of the robot cannot be used."""


class StateError(FpnetError):
    """A saved state of the localizer is missing, corrupt, or made with another configuration."""


class WeightsError(FpnetError):
    """Network weights are missing, corrupt, or made for another feature schema."""


class SiteError(FpnetError):
    """A site description is malformed, contradictory, or refers to something that is missing."""


class LibraryError(FpnetError):
    """A library of floorplans is missing, damaged, empty, or of another version."""


class NotPlacedError(FpnetError):
    """The observations could not be placed on a drawing, so the drawing cannot be assessed."""


def said_of_system(error: OSError) -> str:
    """Return the operating system's message about a file in one line."""
    return f'{error.filename}: {error.strerror}' if error.filename else str(error)
