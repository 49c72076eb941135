# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pipes and devices in place of files are refused in one line, and nobody waits for them."""

import os

import pytest

from fpnet_core.config import load_config
from fpnet_core.drawings.read import read_plan
from fpnet_core.errors import FpnetError
from fpnet_core.io.bags import BagReader
from fpnet_core.io.clouds import read_cloud
from fpnet_core.io.maps import map_yamls, read_map
from fpnet_core.io.recordings import open_scans
from fpnet_core.io.trajectories import read_poses
from fpnet_core.sites.site_files import read_site

MAP = 'image: {}\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n'


def pipe(path):
    os.mkfifo(path)
    return path


def endless(path):
    path.symlink_to('/dev/zero')
    return path


@pytest.mark.parametrize('made', [pipe, endless])
@pytest.mark.parametrize(
    ('name', 'read'),
    [
        ('plan.png', read_map),
        ('plan.png', read_plan),
        ('plan.pdf', read_plan),
        ('plan.yaml', read_plan),
        ('site.yaml', read_site),
        ('fpnet.yaml', load_config),
        ('scan.pcd', read_cloud),
        ('scan.npy', read_cloud),
        ('poses.tum', read_poses),
        ('drive.log', lambda path: list(open_scans(path))),
        ('drive.mcap', lambda path: list(open_scans(path))),
    ],
)
def test_what_never_ends_is_refused(made, name, read, tmp_path):
    with pytest.raises(FpnetError, match='pipe, socket or device'):
        read(made(tmp_path / name))


@pytest.mark.parametrize('made', [pipe, endless])
def test_so_is_the_image_of_a_map(made, tmp_path):
    made(tmp_path / 'plan.pgm')
    (tmp_path / 'plan.yaml').write_text(MAP.format('plan.pgm'))
    for read in (read_map, read_plan):
        with pytest.raises(FpnetError, match=r'plan\.pgm.*pipe, socket or device'):
            read(tmp_path / 'plan.yaml')


def test_so_is_a_part_of_a_bag(tmp_path):
    pipe(tmp_path / 'metadata.yaml')
    with pytest.raises(FpnetError, match=r'metadata\.yaml: it is a pipe'), BagReader(tmp_path):
        pass


def test_maps_are_looked_for_among_regular_files(tmp_path):
    assert map_yamls([pipe(tmp_path / 'a.yaml')]) == []
