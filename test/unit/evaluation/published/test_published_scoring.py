# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What probabilities are worth, and what manifests of weights say, as pages show them."""

from benchmark_reports import MADE, REPORTS, manifest, rows

from fpnet_lab.evaluation.published.makers import published


def table(name, key=''):
    """The rows of a table of a small report."""
    return rows(published(name, REPORTS[name](), MADE)[f'{name}{key}'])


def test_probabilities_are_measured_by_kind_of_trials():
    real, everything = table('calibration')[2:]
    assert real == [
        *('100 cuts of real pairs, report half', '0.009', '94 %', '200', '180', '1', '2 of 364')
    ]
    assert everything == ['all', *real[1:]]


def test_rules_for_claims_say_what_is_never_claimed():
    rule, silent = table('claim_rules')[2:]
    assert rule == ['2', '0.99', '5 m²', '2.5 m', '2 of 42', '0', '1 of 126']
    assert silent[3] == ''


def test_parts_of_the_judge_stand_below_each_other():
    titles, _, row = table('scorer_ablation')
    assert titles == ['judge', '50-100 %']
    assert row == ['features alone', '78, 40, 0.9 %']


def test_claims_of_the_shipped_judge_are_those_of_its_manifest():
    found = manifest('weights_scorer')['figures']
    trials = {row[0]: row for row in table('weights_scorer')[2:]}
    assert set(trials) == {
        *('real maps', 'drawings made into maps', 'generated maps', 'looks of drives'),
        'maps without a plan',
    }
    assert trials['real maps'][1] == f'{found["real"]["trials"]:,.0f}'
    assert trials['maps without a plan'][3:6] == ['', '', '']
    claims = {row[0]: row[1:] for row in table('weights_scorer', '.claims')[2:]}
    assert list(claims) == ['0.9', '0.95', '0.97', '0.99']
    assert claims['0.95'][0] == f'{100 * found["real"]["claimed_right_0.95"]:.1f} %'
