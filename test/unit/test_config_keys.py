# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Keys of the configuration: what there are, and what is said of one that there is not."""

import pytest

from fpnet_core.config import config_keys, load_config
from fpnet_core.errors import ConfigError


def test_every_key_is_one_to_set():
    assert 'seed' in config_keys()
    tree = load_config().model_dump()
    for key in config_keys():
        section, _, leaf = key.partition('.')
        value = tree[section][leaf] if leaf else tree[section]
        assert load_config(None, {key: value}) == load_config()


@pytest.mark.parametrize(
    ('typed', 'meant'),
    [
        ('submap.resolution', 'submap.resolution_m'),
        ('localiser.update_period_s', 'localizer.update_period_s'),
        ('accept_probability', 'localizer.accept_probability'),
        ('sead', 'seed'),
    ],
)
def test_a_key_that_is_none_names_the_one_that_was_meant(typed, meant):
    with pytest.raises(ConfigError, match=f'unknown key {typed}; did you mean {meant}?'):
        load_config(None, {typed: 1})


def test_what_is_like_no_key_gets_no_guess(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text('qqq: 1\n')
    with pytest.raises(ConfigError, match=r'mine\.yaml: unknown key qqq; config/fpnet\.yaml has'):
        load_config(path)
