# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What speaks of a scale, and the posterior that is made of it."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import Weights, read_weights
from fpnet_core.segmentation.scale_figures import FIGURES, ScaleFigures, scale_figures
from fpnet_core.segmentation.scale_model import (
    GRID,
    SCALE_NAME,
    SCALE_SCHEMA,
    ScalePrior,
    model_of,
    packaged_scale_model,
    pooled,
    quantiles,
)
from fpnet_core.types import (
    FREE,
    OCCUPIED,
    GridMap,
    Portal,
    Region,
    RegionLabel,
    Segmentation,
)

CELL_M = 0.1


def two_rooms(door_widths=(0.9, 0.95), wall_cells=4):
    """Rooms of 5 x 4 m and 3 x 4 m, a wall and doors between them, however many."""
    cells = np.full((60, 100 + wall_cells), OCCUPIED, np.int8)
    labels = np.zeros(cells.shape, np.int32)
    for number, (first, width) in enumerate(((10, 50), (60 + wall_cells, 30)), 1):
        labels[10:50, first : first + width] = number
    cells[labels > 0] = FREE
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    areas = [20.0, 12.0] + [0.2] * len(door_widths)
    kinds = [RegionLabel.ROOM] * 2 + [RegionLabel.DOOR] * len(door_widths)
    regions = tuple(
        Region(k, kind, square, square.mean(0), area)
        for k, (kind, area) in enumerate(zip(kinds, areas, strict=True))
    )
    portals = tuple(
        Portal(2 + k, (0, 1), np.array([[0.0, k], [width, k]]))
        for k, width in enumerate(door_widths)
    )
    return Segmentation(GridMap(cells, CELL_M), labels, regions, portals)


def length(figures, name):
    return np.exp(figures.values[FIGURES.index(name)] + figures.reference)


def test_lengths_are_measured_in_metres():
    figures = scale_figures(two_rooms())
    assert length(figures, 'door_50') == pytest.approx(np.sqrt(0.9 * 0.95), rel=1e-6)
    assert length(figures, 'side_50') == pytest.approx(np.sqrt(np.sqrt(20.0 * 12.0)), rel=1e-6)
    assert length(figures, 'width_25') == pytest.approx(3.0 * (4.0 / 3.0) ** 0.25, rel=0.05)
    # Of an even number of cells half a one is lost, of an odd number one is won.
    assert length(figures, 'wall_25') == pytest.approx(0.35, rel=1e-6)
    odd = scale_figures(two_rooms(wall_cells=5))
    assert length(odd, 'wall_25') == pytest.approx(0.55, rel=1e-6)
    assert figures.values[FIGURES.index('log_doors')] == pytest.approx(np.log(3.0))


def test_what_stands_in_a_room_like_a_piece_of_wall_changes_no_length():
    """Rooms keep it for one; a chain of dirt in their middles must not make them narrow."""
    bare = two_rooms()
    cells, labels = bare.grid.cells.copy(), bare.labels.copy()
    for row, col in ((16, 16), (18, 40), (28, 28), (40, 15), (41, 43), (19, 72), (38, 78)):
        cells[row : row + 3, col : col + 9] = OCCUPIED
        labels[row : row + 3, col : col + 9] = 0
    dirty = replace(bare, grid=replace(bare.grid, cells=cells), labels=labels)
    clean, found = scale_figures(bare), scale_figures(dirty)
    assert found.reference == pytest.approx(clean.reference)
    np.testing.assert_allclose(found.values, clean.values)


def test_another_nominal_scale_moves_the_reference_only():
    one, other = (scale_figures(two_rooms(), factor) for factor in (1.0, 1.7))
    counted = FIGURES.index('door_mode'), FIGURES.index('door_agreement')
    keep = np.setdiff1d(np.arange(len(FIGURES)), counted)  # the mode looks near true metres
    kept = [f.values[keep] for f in (one, other)]
    known = ~np.isnan(kept[0]) & ~np.isnan(kept[1])
    assert known.sum() > 15
    np.testing.assert_allclose(kept[0][known], kept[1][known], atol=1e-6)
    assert other.reference - one.reference == pytest.approx(np.log(1.7))


@pytest.mark.parametrize('side', ['plan', 'map'])
def test_a_posterior_is_a_distribution_that_moves_with_the_reference(side):
    model, figures = packaged_scale_model(), scale_figures(two_rooms())
    moved = replace(figures, reference=figures.reference + 0.3)
    one, other = (model.posterior(f, side) for f in (figures, moved))
    assert one.sum() == pytest.approx(1.0)
    assert (one >= 0.0).all()
    shift = quantiles(one, (0.05, 0.5, 0.95)) - quantiles(other, (0.05, 0.5, 0.95))
    np.testing.assert_allclose(shift, 0.3, atol=0.02)


def test_what_a_picture_tells_moves_the_scale_towards_it_whatever_the_unit():
    at = np.linspace(-4.0, 4.0, 161)
    plain = packaged_scale_model().posterior(scale_figures(two_rooms()), 'plan')
    middle = quantiles(plain, (0.5,))[0]
    larger = ScalePrior(at, -0.5 * ((at - middle - 0.4) / 0.2) ** 2)
    moved = quantiles(pooled(plain, larger, 1.0), (0.5,))[0]
    assert middle + 0.03 < moved < middle + 0.4
    per_half = larger.per(0.5)
    assert per_half.median == pytest.approx(larger.median / 2.0)
    np.testing.assert_allclose(pooled(plain, per_half, 0.5), pooled(plain, larger, 1.0))


def test_nothing_measured_is_anything_possible():
    nothing = ScaleFigures(np.full(len(FIGURES), np.nan), None)
    posterior = packaged_scale_model().posterior(nothing, 'plan')
    np.testing.assert_allclose(posterior, 1.0 / len(GRID))


def test_weights_for_other_figures_are_refused():
    weights = read_weights(None, SCALE_SCHEMA, SCALE_NAME)
    network = weights.manifest['network'] | {'figures': ['door_mode']}
    with pytest.raises(WeightsError, match='train scale'):
        model_of(Weights(weights.tensors, weights.manifest | {'network': network}))
