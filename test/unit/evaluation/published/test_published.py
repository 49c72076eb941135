# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports to the tables and figures that pages show, and what the pages of this checkout state."""

from dataclasses import replace
import json
from pathlib import Path
import subprocess
import sys

from benchmark_reports import (
    DRAWINGS,
    GROWTH,
    MADE,
    RECORDED,
    REPORTS,
    SCALES,
    VARIED,
    localization,
    manifest,
    peers,
    robot,
    rows,
    site_figures,
    varied,
)
import numpy as np
import pytest
from stated_figures import contradictions

from fpnet.cli import main
import fpnet_core
from fpnet_core.errors import ConfigError
from fpnet_lab.cli.reports import begin, finish, write_report
from fpnet_lab.evaluation.localization.peers import peer_figures
from fpnet_lab.evaluation.published.figures import pages, stated, write_figures
from fpnet_lab.evaluation.published.makers import MAKERS, joined, published
from fpnet_lab.evaluation.published.weights import WEIGHTS
from fpnet_lab.evaluation.robots.robot_figures import ALL_BANDS
from fpnet_lab.provenance import Provenance, machine


def test_sites_are_told_apart_by_whether_walls_can_tell():
    tables = published('sites', site_figures(), MADE)
    apart, equal = rows(tables['sites'])[2:]
    assert apart[1:4] == ['2', '1', '0']
    assert apart[4:6] == ['12.0 m', '8.0 m']
    assert apart[-1] == '2.5 times'
    assert equal[1:4] == ['1', 'ambiguous 1', '0']
    (found,) = rows(tables['sites.differences'])[2:]
    assert found[:3] == ['90 %', '85 %', '5 %']


def test_figures_of_the_localization_benchmark():
    figures = published('localization', localization(), MADE)
    assert figures['localization.right'] == '2 of 4'
    assert figures['localization.plain_right'] == '2'
    assert figures['localization.first_pose'] == '5.0 m'
    assert figures['localization.false_claims'] == '0'
    lines = {row[0]: row[1:] for row in rows(figures['localization'])}
    assert lines['`exact`'] == ['2', '2', '3.0 m', '0', '0.05 m, 0.4°', '2.8, 93 %', '']
    assert lines['`symmetric`'][2] == '30 m'
    assert lines['`rough`'][:2] == ['1', '0'], 'it counts in no total'
    assert lines['all'][:4] == ['6', '2 of 4', '5.0 m', '3']
    assert lines['on mirrored plans'] == ['1', '', '', '0 claims', '', '', '']


def test_figures_of_peers_are_of_what_all_methods_met():
    [placed] = rows(published('peers', peers(), MADE)['peers.maps'])[2:]
    pairs = 2 * len(ALL_BANDS)
    half = f'{len(ALL_BANDS)} of {pairs}'
    assert placed == ['`fpnet`', half, half, half, f'{pairs} of {2 * pairs}', '0.24 s']
    ours, theirs = rows(published('peers', peers(), MADE)['peers'])[2:]
    assert ours[:4] == ['`fpnet`', '1 of 1', '1 of 1', '0 of 1']
    assert theirs[:4] == ['`monte_carlo`', '1 of 1', '0 of 1', '1 of 1']
    assert (ours[4:6], theirs[5]) == (['2.0 m', '0 of 1'], '1 of 1')
    assert ours[6:] == ['0.05 m', '0.010 s']
    assert peer_figures([]) == {}


def test_figures_of_the_open_benchmark():
    tables = published('open', REPORTS['open'](), MADE)
    ours, silent = rows(tables['open'])[2:4]
    assert ours[:6] == ['`fpnet`', '2 of 3', '1 of 3', '0 of 3', '4.2 m', '7.5 s']
    assert ours[6:] == ['0.07 m', '0.3 deg', '91', '2 of 3', '0.05', '0.03']
    assert silent[4:] == ['none', 'none', 'none', 'none', '0', '0 of 3', 'none', 'none']
    assert '21 cases: track sheets, seed 1, count 3.' in tables['open']
    titles, _, more, _ = rows(tables['open.more'])
    assert titles[1:3] == ["claimed on other buildings' plans", 'on mirrored plans']
    assert titles[3] == 'finished map', 'the track has no other floors'
    assert more[1:4] == ['0 of 3', '1 of 3', '2 of 3, 0 wrong']


def test_figures_of_drawings_and_stated_scales():
    figures = published('drawings', DRAWINGS, MADE)
    assert figures['drawings.right'] == '63 %'
    assert figures['drawings.real_scale_within'] == '93 %'
    assert rows(figures['drawings'])[2] == ['clean', '8', '63 %', '98 %', '', '0 %', '2.4']
    figures = published('stated_scales', SCALES, MADE)
    assert (figures['stated_scales.scatter'], figures['stated_scales.times']) == ('0.010', '280')
    assert rows(figures['stated_scales'])[-1] == ['stated wrong, doubted', '33', '28', '1', '0']


def test_figures_of_robots_maps():
    figures = published('robot', robot(), MADE)
    assert figures['robot.pairs'] == '8'
    assert figures['robot.right_whole'] == '50 %'
    assert figures['robot.undistorted_whole'] == '100 %'
    assert (figures['robot.wrong'], figures['robot.pairs']) == ('4', '8')
    assert (figures['robot.foreign'], figures['robot.foreign_pairs']) == ('8', '16')
    table = rows(figures['robot'])
    assert table[2] == ['all', 'whole', '50 %', '50 %', '1 of 2', '2 of 4']
    assert table[6][:4] == ['without the three distorted drawings', 'whole', '100 %', '100 %']
    assert rows(figures['robot.buildings'])[3] == [
        '`b`', '1', '0, 0 %', '0, 0 %', '0, 0 %', '4 of 4',
    ]  # fmt: skip


def test_figures_of_seeds():
    seeder = published('seeder', REPORTS['seeder'](), MADE)
    assert rows(seeder['seeder'])[2] == ['10', '9', '11.2 s', '8', '19', '0']
    exact, sketch = rows(seeder['seeder.covariance'])[2:]
    assert exact == ['exact', '150', '95.3 %', '2.7']
    assert sketch == ['sketch', '0', '', '']


@pytest.mark.parametrize(('name', 'content'), [('drawings', {'half': 'tune'}), ('nothing', {})])
def test_reports_of_something_else_are_refused(name, content):
    with pytest.raises(ConfigError, match=name):
        published(name, content, MADE)


def constants(*reports):
    """The rows of the table that several runs come to."""
    text = published('constants_varied', joined('constants_varied', reports), MADE)
    return rows(text['constants_varied'])[2:]


def test_several_runs_come_to_one_table_and_the_most_of_a_constant_counts():
    again = varied(1.2, A=('nothing', ''), D=('changed', 'x 1.20: pair-9: other place'))
    pose, _ = constants(VARIED, again)
    assert pose[2:] == ['4', '2', '1', '1', '0', '1']
    both = constants(VARIED, varied(4, D=('nothing', '')))
    assert [row[:3] for row in both[2:]] == [['4', '`pose`', '1'], ['4', 'all', '1']]


def test_other_tables_are_of_one_run():
    with pytest.raises(ConfigError, match=r"2 reports of 'growth'"):
        joined('growth', [GROWTH, GROWTH])
    assert joined('growth', [GROWTH]) is GROWTH


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


def on_pages():
    """What all pages state, by name; they agree, as another test has it."""
    return {each.name: each.text for page in pages(ROOT) for each in stated(page)}


MEASURED_APART = {
    'sites.differences': 'sites.differences',
    'sites.one': 'sites.one',
    'sites.library': 'sites.library',
    'sites.growth': 'sites.library',
}
"""Parts of a benchmark that have nothing in common but its name."""


def test_pages_agree_on_every_figure():
    on_pages = [each for page in pages(ROOT) for each in stated(page)]
    assert contradictions(on_pages) == []
    assert len({each.page for each in on_pages}) >= 3


def test_every_figure_on_a_page_is_one_that_a_benchmark_gives():
    known = {'constants', 'house'}  # counted by tools
    for name in MAKERS:
        known |= set(published(name, REPORTS[name](), MADE))
    named = {each.name for page in pages(ROOT) for each in stated(page)}
    assert named <= known


def test_every_table_on_a_page_says_what_made_it():
    tables = [each for page in pages(ROOT) for each in stated(page) if '\n' in each.text]
    for each in tables:
        assert each.text.startswith('`'), f'{each.page.name}: {each.name}'
        assert 'commit ' in each.text.partition('\n')[0], f'{each.page.name}: {each.name}'
    assert len(tables) >= 4


def test_tables_of_one_benchmark_are_of_one_run():
    """Their first lines have the command, the day and the commit."""
    made = {}
    for name, text in on_pages().items():
        if '\n' in text:
            run = MEASURED_APART.get(name, name.partition('.')[0])
            made.setdefault(run, set()).add(text.partition('\n')[0])
    assert {name: lines for name, lines in made.items() if len(lines) > 1} == {}


def test_every_figure_in_a_sentence_has_its_table_on_a_page():
    """The table says where the figure is from; scales of vector drawings are one row each."""
    names = on_pages()
    tables = {name.partition('.')[0] for name, text in names.items() if '\n' in text}
    sentences = {name.partition('.')[0] for name, text in names.items() if '\n' not in text}
    assert sentences - tables <= {'drawings_pdf', 'drawings_svg', 'drawings_dxf'}


def test_figures_in_sentences_are_those_of_the_tables():
    figures = on_pages()
    table = {row[0]: row for row in rows(figures['localization'])}
    assert figures['localization.right'] == table['all'][2]
    assert figures['localization.first_pose'] == table['all'][3]
    claims = [row for name, row in table.items() if name.startswith('on ')]
    assert len(claims) == 2
    false = sum(int(row[4].split()[0]) for row in claims)
    assert figures['localization.false_claims'] == str(false)
    *maps, whole, half, third, tenth = rows(figures['robot'])[-8:]
    names = ('whole', 'half', 'third', 'tenth')
    assert [figures[f'robot.right_{name}'] for name in names] == [row[2] for row in maps]
    undistorted = [row[2] for row in (whole, half, third, tenth)]
    assert [figures[f'robot.undistorted_{name}'] for name in names] == undistorted
    for column, wrong, cases in ((4, 'wrong', 'pairs'), (5, 'foreign', 'foreign_pairs')):
        counts = np.array([row[column].split(' of ') for row in maps], dtype=int).sum(axis=0)
        assert figures[f'robot.{wrong}'] == str(counts[0])
        assert figures[f'robot.{cases}'].replace(',', '') == str(counts[1])
    seeds = rows(figures['demo'])[2:]
    assert figures['demo.met'].endswith(f'of {len(seeds)}')
    assert figures['demo.wrong'] == str(sum(int(row[2]) for row in seeds))
    assert figures['demo.latest'] == f'{max(float(row[4]) for row in seeds):.1f} m'


def test_the_readme_says_on_how_many_foreign_plans_it_was_tried():
    table = {row[0]: row for row in rows(on_pages()['localization'])}
    foreign = sum(int(row[1]) for name, row in table.items() if name.startswith('on '))
    assert f' of {foreign} drives' in (ROOT / 'README.md').read_text(encoding='utf-8')


@pytest.mark.parametrize('name', WEIGHTS)
def test_pages_state_what_manifests_of_shipped_weights_hold(name):
    """Whatever was trained anew, and when: nobody can forget the page."""
    states = on_pages()
    expected = published(name, manifest(name), MADE)
    shown = {key: text for key, text in expected.items() if key in states}
    assert name in shown
    for key, text in shown.items():
        assert rows(states[key]) == rows(text), key
        assert states[key].startswith('`fpnet train ')
