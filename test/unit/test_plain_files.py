# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files and texts that others wrote: pipes, YAML of tricks, control characters."""

import logging
import os

import pytest

from fpnet.cli import common, main
from fpnet.recordings.opening import open_scans
from fpnet.recordings.trajectories import read_poses
from fpnet_core import plain_yaml
from fpnet_core.config import load_config
from fpnet_core.drawings.read import read_plan
from fpnet_core.errors import FpnetError, MapFormatError
from fpnet_core.io.bags import BagReader
from fpnet_core.io.clouds import read_cloud
from fpnet_core.io.maps import map_yamls, read_map
from fpnet_core.plain_yaml import parse_yaml, read_yaml
from fpnet_core.printable import printable
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


def test_plain_values_are_read(tmp_path):
    (tmp_path / 'a.yaml').write_text('a: [1, 2.5, true, text]\n', encoding='utf-8')
    assert read_yaml(tmp_path / 'a.yaml', MapFormatError) == {'a': [1, 2.5, True, 'text']}
    assert parse_yaml('') is None


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('a: !!python/object/apply:os.system ["touch marker"]', 'constructor'),
        ('a: !!python/name:os.system', 'constructor'),
        ('a: &x [1]\nb: *x', r'alias \*x .* write the value out'),
        ('&x [*x]', 'alias'),
        ('[' * 1200 + ']' * 1200, 'nested too deeply'),
        ('a: 2001-99-99', 'month'),
        ('a: ' + '9' * 5000, 'digits'),
        ('a: [', 'line 1'),
        ('a: !!float abc', 'float'),
        ('{[a]: 1, {b: 1}: 2}', 'unhashable'),
    ],
)
def test_everything_else_is_refused_in_one_line(tmp_path, monkeypatch, text, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=message) as refused:
        parse_yaml(text)
    assert '\n' not in str(refused.value)
    assert list(tmp_path.iterdir()) == []


def test_files_of_another_size_or_encoding_are_refused(tmp_path, monkeypatch):
    path = tmp_path / 'a.yaml'
    path.write_bytes(b'\xff\xfea: 1')
    with pytest.raises(MapFormatError, match=r'a\.yaml is not valid YAML: .* UTF-8'):
        read_yaml(path, MapFormatError, 'map')
    monkeypatch.setattr(plain_yaml, 'MAX_BYTES', 5)
    path.write_bytes(b'a: 1 #')
    with pytest.raises(MapFormatError, match='at most 5 bytes'):
        read_yaml(path, MapFormatError, 'map')


@pytest.mark.parametrize(('what', 'named'), [('map', 'map '), ('', '')])
def test_what_cannot_be_read_is_named(tmp_path, what, named):
    with pytest.raises(MapFormatError, match=f'^cannot read {named}{tmp_path}: Is a directory$'):
        read_yaml(tmp_path, MapFormatError, what)


EVIL = '/scan\x1b]0;owned\x07\x1b[2K\b\u202e'
WRITTEN = '/scan\\x1b]0;owned\\x07\\x1b[2K\\x08\\u202e'


@pytest.mark.parametrize(
    ('text', 'written'),
    [('/points', '/points'), ('Büro 3,5 m²\n  next', 'Büro 3,5 m²\n  next'), (EVIL, WRITTEN)],
)
def test_control_characters_are_written_out(text, written):
    assert printable(text) == written


def test_so_they_are_in_lines_and_tables(capsys):
    common.say(EVIL, None)
    common.show_table(['topic', 'n'], [(EVIL, '3')], None, width=120)
    said = capsys.readouterr().out
    assert said.count(WRITTEN) == 2
    assert '\x1b' not in said


def test_so_they_are_in_errors(capsys):
    with pytest.raises(SystemExit):
        main(['doctor', EVIL])
    said = capsys.readouterr().err
    assert WRITTEN in said
    assert '\x1b' not in said


def test_so_they_are_in_the_log(capsys, monkeypatch):
    root = logging.getLogger()
    monkeypatch.setattr(root, 'handlers', [])
    with pytest.raises(SystemExit):
        main(['doctor', 'missing.bag'])
    logging.getLogger('fpnet_core.test').warning('left out: %s', EVIL)
    assert WRITTEN in capsys.readouterr().err
