# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_lab.metrics import MatchCounts, count_matches, matching_score


def test_counts_of_a_literal_case():
    labels = np.array([4, 2, UNMATCHED, IGNORE, 7])
    # Right; wrong partner; partner of an unmatched region; on an ignored region (not judged).
    pairs = np.array([[4, 0], [3, 1], [2, 2], [5, 3]])
    counts = count_matches(pairs, labels)
    assert counts == MatchCounts(correct=1, predicted=3, true=3)
    assert counts.precision == pytest.approx(1 / 3)
    assert counts.recall == pytest.approx(1 / 3)
    assert counts.f1 == pytest.approx(1 / 3)


def test_nothing_predicted_and_nothing_there():
    none = count_matches(np.zeros((0, 2), np.int64), np.array([UNMATCHED, IGNORE]))
    assert none == MatchCounts(0, 0, 0)
    assert (none.precision, none.recall, none.f1) == (0.0, 1.0, 1.0)


def test_pooling_adds_and_the_matching_score_averages_pairs():
    one, other = MatchCounts(1, 1, 4), MatchCounts(0, 3, 2)
    pooled = one + other
    assert pooled == MatchCounts(1, 4, 6)
    assert pooled.precision == 0.25
    assert matching_score([one, other]) == 0.5
    # A pair that claims nothing although partners exist scores 0; one without both is left out.
    assert matching_score([one, MatchCounts(0, 0, 3), MatchCounts(0, 0, 0)]) == 0.5
    assert matching_score([]) == 0.0
