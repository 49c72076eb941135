# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A newcomer's questions: a search for the word that an engineer would type finds the file."""

from pathlib import Path
import re

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ('fpnet_core', 'fpnet', 'fpnet_ros', 'msg_adapters')
SOURCES = {
    str(path.relative_to(ROOT)): path.read_text(encoding='utf-8')
    for package in PACKAGES
    for path in (ROOT / package).rglob('*.py')
}


def first(word):
    """Return the file with the most lines that hold ``word``, as ``rg -c -i`` counts them."""
    pattern = re.compile(word, re.IGNORECASE)
    counted = {
        name: sum(bool(pattern.search(line)) for line in source.splitlines())
        for name, source in SOURCES.items()
    }
    return max(counted, key=counted.get)


@pytest.mark.parametrize(
    ('word', 'file'),
    [
        ('kidnap', 'fpnet_core/localizer/kidnap.py'),
        ('odometry_?reset', 'fpnet_core/localizer/odometry_monitor.py'),
        ('local pose filter', 'fpnet_core/localizer/pose_filter.py'),
        ('is_accepted', 'fpnet_core/localizer/tracking.py'),
        ('log odds|log_odds', 'fpnet_core/scoring/scorer.py'),
        ('welsch', 'fpnet_core/pose/refine.py'),
        ('mirror', 'fpnet_core/localizer/tracking.py'),
        ('interval', 'fpnet_core/segmentation/scale.py'),
        ('dustbin|matchab', 'fpnet_core/models/joint_attention.py'),
        ('grade_', 'fpnet_core/config.py'),
        ('fft', 'fpnet_core/pose/raster_search.py'),
        ('deskew', 'fpnet_core/odometry/kiss.py'),
        ('ifc', 'fpnet_core/drawings/formats/ifc.py'),
        ('scale bar', 'fpnet_core/drawings/scale_bars.py'),
        ('OccupancyGrid', 'msg_adapters/grids.py'),
        ('broadcast', 'fpnet_ros/outputs.py'),
        ('rosbag', 'fpnet_core/io/bags.py'),
        ('map_server', 'fpnet_core/io/maps.py'),
        ('site.yaml', 'fpnet_core/sites/site_files.py'),
        ('upside down', 'fpnet_core/doctor/sensor.py'),
        ('LaserScan', 'fpnet_core/io/laserscan.py'),
    ],
)
def test_a_search_finds_the_file(word, file):
    assert first(word) == file
