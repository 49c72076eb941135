# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""YAML that others wrote: plain values, or one line that says why not."""

import pytest

from fpnet_core import plain_yaml
from fpnet_core.errors import MapFormatError
from fpnet_core.plain_yaml import parse_yaml, read_yaml


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
