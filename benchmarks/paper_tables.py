#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reproduction of the paper's three tables: training, and tables beside the paper's figures.

Usage:
  python benchmarks/paper_tables.py train --pairs runs/clips --out runs/paper
  python benchmarks/paper_tables.py write --runs runs/paper --data ../shared/data \
      [--limit 100] [--page docs/matching_tables.md] [--notes notes/matching_tables.md]

``train`` trains ``paper``, ``superglue`` and, with fewer epochs, the networks of Table III, one
after the other, on the CPU or with --device cuda; a repeated call resumes. ``write`` matches the
same pairs with every method and writes the page. It stores each table's report under --runs and
resumes there, until the program changes. The page contains the paper's tables, the notes all
tables with all columns. Without networks of Table III under --runs, that table on the page stays
unchanged, with its own date.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
import json
from pathlib import Path
import subprocess
import sys
import tempfile
from typing import Any

import yaml

from fpnet_lab.kept import digest, make_once
from fpnet_lab.provenance import Provenance
from fpnet_lab.scores import Table, Unit, Units

SHARE = Unit(digits=1, factor=100.0, nothing='-')
FPNET = str(Path(sys.executable).with_name('fpnet'))

VARIANTS: dict[str, dict[str, Any]] = {
    'full': {},
    'match': {'loss.topology': 0.0, 'loss.spatial': 0.0},
    'spatial': {'loss.topology': 0.0},
    'topo': {'loss.spatial': 0.0},
    'no_connectivity': {'network.edge_mapping': 'proximity'},
    'no_distance': {'network.edge_mapping': 'connectivity'},
}
"""Networks of Table III, as changes of the preset ``paper``."""

ABLATIONS = {
    'loss_match': ('match', {}, 80, 87),
    'loss_match + loss_spatial': ('spatial', {}, 81, 86),
    'loss_match + loss_topo': ('topo', {}, 79, 86),
    'loss_all': ('full', {}, 85, 90),
    'without edge-connectivity': ('no_connectivity', {}, 70, 79),
    'without edge-distance': ('no_distance', {}, 71, 83),
    'without threshold grading': ('full', {'grade_thresholds': [0.3] * 3}, 84, 90),
}
"""Rows of Table III: network, matcher settings, and the paper's MS and TS [%]."""

KEYS = ('auc1', 'auc10', 'auc20', 'ms', 'ts')
PUBLISHED = {
    'synthetic': {
        'nearest_neighbor': (7.3, 12.449, 13.542, 23.691, 15.2),
        'ombb': (17.756, 70.154, 76.944, None, 84.0),
        'superglue': (67.758, 77.438, 78.272, 70.071, 81.0),
        'paper': (74.734, 83.339, 84.067, 85.9, 90.0),
    },
    'real': {
        'nearest_neighbor': (4.156, 7.781, 8.391, 16.002, 10.0),
        'ombb': (10.264, 49.082, 60.535, None, 56.0),
        'superglue': (45.907, 52.301, 53.253, 53.692, 55.0),
        'paper': (63.034, 69.303, 69.642, 57.393, 76.0),
    },
    'challenging': {
        'nearest_neighbor': (1.7, 4.5, 5.5, 9.1, 5.0),
        'ombb': (14.1, 18.2, 26.4, None, 22.5),
        'superglue': (20.9, 34.1, 37.6, 60.5, 47.8),
        'paper': (26.2, 40.7, 44.7, 71.2, 54.6),
    },
}
"""The paper's Tables I and II [%] in the order of KEYS; ombb is listed with its "Shahbandi"."""

RECALLS = {'recall_1m_10deg': '1 m, 10°', 'recall_05m_5deg': '0.5 m, 5°'}
SHORT_COLUMNS = {'recall_1m_10deg': RECALLS['recall_1m_10deg']}
"""Titles of recalls in metres: all are in the notes, one is on the page."""

TABLE_III = '\n## Ablations of `paper` on the synthetic set (Table III)'

NAMES = {
    'fpnet_network': 'its network alone',
    'nearest_neighbor': 'nearest neighbour',
    'ombb': 'ombb (paper: Shahbandi)',
}


def main() -> None:
    """Train or write, as given on the command line."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    actions = parser.add_subparsers(dest='action', required=True)
    training = actions.add_parser('train')
    training.add_argument('--pairs', type=Path, required=True)
    training.add_argument('--out', type=Path, required=True)
    training.add_argument('--epochs', type=int, default=8)
    training.add_argument('--ablation-epochs', type=int, default=3)
    training.add_argument('--device', default='cpu')
    write = actions.add_parser('write')
    write.add_argument('--runs', type=Path, required=True)
    write.add_argument('--data', type=Path, required=True)
    write.add_argument('--limit', type=int, default=100)
    write.add_argument('--robot-limit', type=int, default=40)
    write.add_argument('--page', type=Path, default=Path('docs/matching_tables.md'))
    write.add_argument('--notes', type=Path, default=Path('notes/matching_tables.md'))
    arguments = parser.parse_args()
    if arguments.action == 'train':
        for preset in ('paper', 'superglue'):
            train(arguments, preset, arguments.epochs, preset, {})
        for name, changes in VARIANTS.items():
            train(arguments, f'ablations/{name}', arguments.ablation_epochs, 'paper', changes)
    else:
        write_page(arguments)


def train(
    arguments: argparse.Namespace, out: str, epochs: int, preset: str, changes: dict[str, Any]
) -> None:
    """Train one network to its last epoch."""
    options = [f'--set={key}={value}' for key, value in changes.items()]
    run('train', 'matcher', '--preset', preset, '--data', arguments.pairs,
        '--out', arguments.out / out, '--epochs', epochs, '--device', arguments.device,
        '--set=patience=99', *options
    )  # fmt: skip


@dataclass(frozen=True)
class Report:
    """JSON report of a benchmark."""

    text: str


def write_page(arguments: argparse.Namespace) -> None:
    """Match all pairs with all methods and write the tables as Markdown."""
    made = Provenance.now()
    runs, data, limit = arguments.runs, arguments.data, arguments.limit
    plans = ('--plans', data / 'bormann' / 'floorplan')
    wanted = {name: words(name, limit, *plans) for name in PUBLISHED}
    wanted['tours'] = words('tours', limit)
    papers = list(wanted)
    wanted['robot'] = words('robot', arguments.robot_limit, '--data', data)
    is_trained = all(network_of(runs, name).is_file() for name in VARIANTS)
    if is_trained:
        wanted |= {row: ablation(runs, row, limit) for row in ABLATIONS}
    files = sorted((*runs.glob('**/matcher.safetensors'), *runs.glob('*.yaml')))
    tasks = {f'{row}-{digest(asked, files)}': asked for row, asked in wanted.items()}
    texts = make_once(runs / 'reports', Report, tasks, bench)
    reports = {row: json.loads(report.text) for row, report in zip(wanted, texts, strict=True)}
    page = [
        heading(limit, made),
        *(paper_table(name, reports[name], SHORT_COLUMNS) for name in PUBLISHED),
    ]
    if is_trained:
        found = {row: reports[row]['methods']['fpnet'] for row in ABLATIONS}
        page.append(ablation_table(found, made))
    else:
        _, title, kept = arguments.page.read_text(encoding='utf-8').partition(TABLE_III)
        page.append(f'{title}{kept.rstrip()}\n')
    notes = [
        notes_heading(made),
        *(paper_table(name, reports[name]) for name in papers),
        robot_table(reports['robot']),
    ]
    arguments.page.write_text('\n'.join(page), encoding='utf-8')
    arguments.notes.write_text('\n'.join(notes), encoding='utf-8')


def words(pair_set: str, limit: int, *more: object) -> list[str]:
    """Return the command that matches one set of pairs."""
    return ['bench', 'matching', '--set', pair_set, '--limit', str(limit), *map(str, more)]


def network_of(runs: Path, name: str) -> Path:
    """Return the weights file of a network of Table III."""
    return runs / 'ablations' / name / 'matcher.safetensors'


def ablation(runs: Path, row: str, limit: int) -> list[str]:
    """Return the command for one row of Table III, on the synthetic set."""
    name, settings, _, _ = ABLATIONS[row]
    config = runs / f'ablation_{row.replace(" ", "_")}.yaml'
    config.write_text(yaml.safe_dump({'matcher': settings}), encoding='utf-8')
    network = ('--weights', network_of(runs, name))
    return words('synthetic', limit, '--methods', 'fpnet', *network, '--config', config)


def bench(asked: list[str]) -> Report:
    """Run a benchmark and return its report."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, 'report.json')
        run(*asked, '--json', path)
        return Report(path.read_text(encoding='utf-8'))


def run(*words: object) -> None:
    """Run an ``fpnet`` command and stop if it fails."""
    subprocess.run([FPNET, *map(str, words)], check=True)  # noqa: S603 (our own command)


def heading(limit: int, made: Provenance) -> str:
    """Return the first lines of the page."""
    return f"""# The paper's tables

This page compares the region matching of fpnet_ros with the figures that the FloorplanNet paper
publishes (in brackets).

Written by `python benchmarks/paper_tables.py write`
({made.date}, commit {made.commit}, {made.machine}):
at most {limit} pairs per set, the same for all methods, in percent. The paper's plans and sampler
are not public, so its figures are of other pairs.

- **AUC@N**: area under the error curve up to N degrees; the error is the larger one of the
  rotation and of the direction of translation.
- **MS**, matching score: share of predicted region matches that are correct.
- **TS**, transform score: rotation within 3.2°, scale within 7 %, direction within 20°.
- **1 m, 10°**: share of placements this near. Unlike AUC and TS it does not depend on the frames'
  origins.

`fpnet` is the shipped matcher; *its network alone* leaves out the geometric consensus. `paper` and
`superglue` are our implementations, trained on parts of generated maps as in the paper, with the
data and time of one CPU core. More columns, ray-cast tours and real robot maps are in
`notes/matching_tables.md`.
"""


def notes_heading(made: Provenance) -> str:
    """Return the first lines of the notes with all tables."""
    return f"""# Matching tables

All sets and columns behind [the paper's tables](../docs/matching_tables.md), which explains them.

Written by `python benchmarks/paper_tables.py write`
({made.date}, commit {made.commit}, {made.machine}). Percent; in brackets the paper's own figures.
"""


def paper_table(name: str, report: dict[str, Any], recalls: Mapping[str, str] = RECALLS) -> str:
    """Return one set's table with the given recalls, and the paper's figures in brackets."""
    rows = []
    for method, found in report['methods'].items():
        theirs = PUBLISHED.get(name, {}).get(method, (None,) * len(KEYS))
        cells = [beside(found[key], other) for key, other in zip(KEYS, theirs, strict=True)]
        cells += [SHARE.text(found[key]) for key in recalls]
        cells.append(Units.NUMBER.to(1).text(found['ms_per_pair']))
        rows.append([NAMES.get(method, method), *cells])
    titles = ('method', 'AUC@1', 'AUC@10', 'AUC@20', 'MS', 'TS', *recalls.values())
    table = Table((*titles, 'ms per pair'), rows).markdown()
    return f'\n## {name.capitalize()}: {report["pairs"]} pairs\n\n{table}\n'


def robot_table(report: dict[str, Any]) -> str:
    """Return a table of each method's right results and wrong acceptances."""
    rows = []
    for method, found in report['methods'].items():
        shares = [(band['right'], band['wrong_and_claimed']) for band in found['bands'].values()]
        cells = [f'{SHARE.text(right)} ({SHARE.text(wrong)})' for right, wrong in shares]
        rows.append([NAMES.get(method, method), *cells, Units.COUNT.text(found['ms_per_pair'])])
    table = Table(('method', *report['methods']['fpnet']['bands'], 'ms per pair'), rows).markdown()
    said = 'Right transforms by share of free space that is kept; in brackets wrong acceptances.'
    return f'\n## Robot maps on their floorplans: {report["pairs"]} pairs\n\n{said}\n\n{table}\n'


def ablation_table(found: dict[str, dict[str, float]], made: Provenance) -> str:
    """Return Table III."""
    rows = [
        [name, beside(found[name]['ms'], ms), beside(found[name]['ts'], ts)]
        for name, (_, _, ms, ts) in ABLATIONS.items()
    ]
    table = Table(('variant', 'MS', 'TS'), rows).markdown()
    said = f'{made.date}, commit {made.commit}, {made.machine}.'
    return f'{TABLE_III}\n\n{said}\n\n{table}\n'


def beside(share: float, published: float | None) -> str:
    """Return a share in percent, followed by the published value."""
    return SHARE.text(share) + ('' if published is None else f' ({published:.1f})')


if __name__ == '__main__':
    main()
