# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Configuration: every key documented, the files that are made of it, and what is refused."""

from pathlib import Path

import pytest
import yaml

from fpnet_core.config import FpnetConfig, Section, config_keys, load_config
from fpnet_core.config_docs import config_fields, render_markdown, render_yaml
from fpnet_core.errors import ConfigError

ROOT = Path(__file__).parents[2]
SHIPPED, PAGE = ROOT / 'config' / 'fpnet.yaml', ROOT / 'docs' / 'parameters.md'


def test_the_shipped_file_is_the_rendered_one():
    assert SHIPPED.read_text(encoding='utf-8').startswith(render_yaml()), (
        'run: python -m fpnet_ros.settings > config/fpnet.yaml'
    )
    assert load_config(SHIPPED) == FpnetConfig()


def test_the_reference_page_is_the_rendered_one():
    assert PAGE.read_text(encoding='utf-8') == render_markdown(), (
        'run: python -m fpnet_core.config_docs markdown > docs/parameters.md'
    )


def test_the_reference_has_unit_range_and_default():
    page = render_markdown()
    assert '| `submap.resolution_m` | float | m | >= 0.02, <= 0.2 | `0.05` | Cell size' in page
    assert '| `localizer.drift_deg_per_m` | float | deg/m |' in page
    assert page.count('\n| `') == len(list(config_fields()))


def test_every_key_is_documented():
    undocumented = [field.key for field in config_fields() if len(field.description) < 10]
    assert undocumented == []


def test_floats_stay_floats_in_yaml():
    # ROS refuses an integer for a parameter that was declared as a double.
    tree = yaml.safe_load(render_yaml())['/**']['ros__parameters']
    for field in config_fields():
        value = tree
        for part in field.key.split('.'):
            value = value[part]
        values = value if field.is_list else [value]
        assert {type(v) for v in values} <= {field.kind}, field.key


def test_a_type_that_no_parameter_can_hold_is_refused():
    class Bad(Section):
        maybe: float | None = None

    with pytest.raises(TypeError, match='maybe'):
        list(config_fields(Bad))


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('submap: [' + '1, ' * 5000 + '1]', 'submap'),
        ('seed: ' + '9' * 5000, 'digits'),
        ('seed: &a [1]\nsubmap: *a', 'alias'),
        ('seed: !!python/name:os.system', 'constructor'),
    ],
)
def test_a_file_of_tricks_is_refused_in_a_short_line(tmp_path, text, message):
    (tmp_path / 'a.yaml').write_text(text)
    with pytest.raises(ConfigError, match=message) as refused:
        load_config(tmp_path / 'a.yaml')
    assert len(str(refused.value)) < 400


def test_there_are_few_keys_and_the_page_opens_with_the_five_to_touch():
    keys = [field.key for field in config_fields()]
    assert len(keys) < 40
    opening = render_markdown().split('## ')[1]
    assert opening.startswith('Set these first')
    assert sum(f'| `{key}` |' in opening for key in keys) == 5


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
