# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where a ROS workspace looks for files of a package; all else is in pyproject.toml."""

from pathlib import Path

from setuptools import setup

NAME = 'fpnet_ros'
SHARE = f'share/{NAME}'


def files(pattern: str) -> list[str]:
    """Return the files under the package root that match, sorted for reproducible builds."""
    root = Path(__file__).resolve().parent
    return sorted(str(path.relative_to(root)) for path in root.glob(pattern))


setup(
    python_requires='>=3.11',
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (SHARE, ['package.xml']),
        (f'{SHARE}/config', files('config/*')),
        (f'{SHARE}/launch', files('launch/*.launch.py')),
    ],
)
