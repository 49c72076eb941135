# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from setuptools import find_packages, setup

NAME = 'fpnet_ros'
SHARE = f'share/{NAME}'


def files(pattern: str) -> list[str]:
    """Return the files under the package root that match, sorted for reproducible builds."""
    root = Path(__file__).resolve().parent
    return sorted(str(path.relative_to(root)) for path in root.glob(pattern))


setup(
    name=NAME,
    version='0.1.0',
    description='Localises a robot on a floorplan from lidar, without an initial pose',
    author='The fpnet_ros developers',
    maintainer='The fpnet_ros developers',
    maintainer_email='fpnet-ros@example.com',
    license='Apache-2.0',
    python_requires='>=3.11',
    packages=find_packages(
        include=['fpnet_core', 'fpnet_core.*', 'msg_adapters', 'msg_adapters.*', NAME, f'{NAME}.*']
    ),
    package_data={
        'fpnet_core.weights': ['*.safetensors', '*.json'],
        'fpnet_core.report': ['templates/*'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (SHARE, ['package.xml']),
        (f'{SHARE}/config', files('config/*')),
        (f'{SHARE}/launch', files('launch/*.launch.py')),
    ],
    # Distributions name the libraries differently (opencv-python-headless is python3-opencv), so
    # rosdep reads package.xml and pip reads requirements.txt; a list here would refuse one side.
    install_requires=['setuptools'],
    extras_require={
        'cluster': ['distributed>=2025.1'],
        'e57': ['pye57>=0.4.1'],
        'ifc': ['ifcopenshell>=0.8.0'],
        'plans': ['ezdxf>=1.4.0', 'pypdfium2>=5.0.0', 'svgelements>=1.9.6'],
        'test': ['pytest'],
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'fpnet = fpnet_core.cli:main',
            'localizer = fpnet_ros.localizer:main',
            'odometry = fpnet_ros.odometry:main',
            'floorplan_server = fpnet_ros.floorplan_server:main',
            'replay = fpnet_ros.replay:main',
        ],
    },
)
