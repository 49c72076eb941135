# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures between markers: where pages disagree, and how they are written."""

from dataclasses import replace
import json
from pathlib import Path
import subprocess
import sys

from benchmark_reports import DRAWINGS, MADE, RECORDED, REPORTS, manifest
import pytest
from stated_figures import contradictions

from fpnet.cli import main
import fpnet_core
from fpnet_core.errors import ConfigError
from fpnet_lab.cli.reports import begin, finish, write_report
from fpnet_lab.evaluation.published.figures import pages, stated, write_figures
from fpnet_lab.evaluation.published.makers import published
from fpnet_lab.provenance import Provenance, machine

ROOT = Path(__file__).resolve().parents[4]


def test_pages_that_disagree_are_named(tmp_path):
    for name, text in {'README.md': '60 of 66', 'docs/a.md': '61 of 66'}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f'Right: <!-- f:suite.right -->{text}<!-- / -->.\n')
    on_pages = [each for page in pages(tmp_path) for each in stated(page)]
    (line,) = contradictions(on_pages)
    assert 'suite.right' in line
    assert '61 of 66' in line
    changed = write_figures(pages(tmp_path), {'suite.right': '62 of 66', 'other': '1'})
    assert [page.name for page in changed] == ['README.md', 'a.md']
    assert (tmp_path / 'README.md').read_text() == (
        'Right: <!-- f:suite.right -->62 of 66<!-- / -->.\n'
    )
    assert write_figures(pages(tmp_path), {'suite.right': '62 of 66'}) == []


@pytest.mark.parametrize(
    'text',
    [
        '<!-- figures: a -->\n| 1 |\n',
        'x <!-- f:a -->1\n<!-- / -->',
        'x\n<!-- f:a -->1<!-- / -->',
        '<!--f:a-->1<!-- / -->',
    ],
)
def test_a_marker_that_is_not_closed_is_refused_and_nothing_is_written(tmp_path, text):
    good, bad = tmp_path / 'good.md', tmp_path / 'bad.md'
    good.write_text('Is <!-- f:a -->1<!-- / -->')
    bad.write_text(text)
    with pytest.raises(ConfigError, match=r'bad\.md'):
        write_figures([good, bad], {'a': '2'})
    assert '1' in good.read_text()


@pytest.mark.parametrize('name', REPORTS)
def test_a_benchmark_ends_with_the_tables_that_pages_have(name, tmp_path, capsys):
    report = json.loads(json.dumps(REPORTS[name]()))
    finish(name, tmp_path / 'report.json', report)
    shown = capsys.readouterr().out
    tables = [text for text in published(name, report, MADE).values() if '\n' in text]
    assert tables
    for text in tables:
        assert text.partition('\n\n')[2].strip() in shown
    written = json.loads((tmp_path / 'report.json').read_text())
    assert written.pop('made')['commit'] is not None
    assert written == report


def test_the_command_writes_pages_and_asks_how_a_report_was_made(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'docs').mkdir()
    page, file = tmp_path / 'README.md', tmp_path / 'drawings.json'
    page.write_text('Read right: <!-- f:drawings.right -->?<!-- / -->\n')
    file.write_text(json.dumps(DRAWINGS))
    with pytest.raises(SystemExit, match='1'):
        main(['bench', 'figures', f'drawings={file}'])
    assert 'has no provenance' in capsys.readouterr().err
    file.write_text(json.dumps(MADE.in_report(DRAWINGS)))
    with pytest.raises(SystemExit, match='0'):
        main(['bench', 'figures', f'drawings={file}'])
    assert '-->63 %<!--' in page.read_text()


def test_provenance_is_of_this_checkout():
    made = Provenance.now()
    git = subprocess.run(
        ['git', '-C', ROOT, 'rev-parse', 'HEAD'], capture_output=True, text=True, check=False
    )
    if git.returncode == 0:
        assert git.stdout.startswith(made.commit.removesuffix('+'))
    assert made.machine == machine()
    assert Provenance.of(made.in_report({'a': 1})) == made
    assert Provenance.of({}) is None
    with pytest.raises(ConfigError, match='run the benchmark again'):
        Provenance.of({'made': {'by': 'hand'}})


def test_a_report_is_of_what_began_it(tmp_path, monkeypatch):
    words = ['fpnet', 'bench', 'scale', '--json', 'a', '--plot=b', '-x', '/bin/sh', '--y=/a/b']
    monkeypatch.setattr(sys, 'argv', words)
    begin()
    monkeypatch.setattr(sys, 'argv', ['fpnet', 'something', 'else'])
    write_report(tmp_path / 'report.json', {})
    made = json.loads((tmp_path / 'report.json').read_text())['made']
    assert made['command'] == 'fpnet bench scale -x sh --y=b'


def test_several_reports_of_one_name_stand_in_one_table(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'docs').mkdir()
    page = tmp_path / 'README.md'
    page.write_text('<!-- figures: recordings -->\n<!-- end -->\n')
    words = []
    for clouds in ('untimed', 'instant'):
        made = replace(MADE, command=f'python x.py --clouds {clouds}')
        file = tmp_path / f'{clouds}.json'
        file.write_text(json.dumps(made.in_report(RECORDED | {'clouds': clouds})))
        words.append(f'recordings={file}')
    with pytest.raises(SystemExit, match='0'):
        main(['bench', 'figures', *words])
    above, *rest = page.read_text().splitlines()[1:]
    assert above.count('commit abc1234') == 2
    assert 'instant' in above
    assert sum('beams16' in line for line in rest) == 2


def test_a_manifest_of_weights_tells_how_they_were_made(tmp_path):
    folder = Path(fpnet_core.__path__[0]) / 'weights'
    made = Provenance.of_weights(manifest('weights_doors'), folder / 'doors.json')
    assert made.command.startswith('fpnet train doors')
    assert made.machine.endswith('weights/doors.json')
    if Provenance.now().commit:
        assert len(made.commit) >= 7
        assert made.date >= '2026-11-23'
    assert Provenance.of_weights({'data': {'samples': 3}}, folder / 'doors.json') is None
    assert Provenance.of_weights({'data': '../shared/data'}, folder / 'doors.json') is None
    outside = Provenance.of_weights({'data': {'command': 'x'}}, tmp_path / 'x.json')
    assert 'outside of a checkout' in str(outside)
