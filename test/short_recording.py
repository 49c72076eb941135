# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The start of a simulated recording: most tests need no whole tour."""

from dataclasses import replace

from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording


def start_of_recording(seconds, lidar, seed=1):
    """Return recording 1 of a lidar model as if it had ended after so many seconds."""
    recording = make_recording(seed, RecordingOptions(lidar=lidar), threads=1)
    tour, count = recording.tour, round(seconds * 100.0)
    parts = ('time_s', 'xy', 'yaw_rad', 'tilt_rad')
    short = replace(tour, **{name: getattr(tour, name)[:count] for name in parts})
    return replace(recording, tour=short)
