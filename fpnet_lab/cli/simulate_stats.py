# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate stats``: comparison of generated and real storeys."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import track
from fpnet_lab.cli.reports import finish

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fpnet_lab.sim.population.comparison import Row, TwoSample
    from fpnet_lab.sim.population.statistics import FloorMeasures

REAL_FOLDER = Path('../shared/data/bormann')


def command(
    count: Annotated[int, typer.Option('--count', min=10, help='Storeys to generate.')] = 200,
    seed: common.SeedOption = 0,
    data: Annotated[
        Path,
        typer.Option('--data', metavar='DIR', help='Folder with floorplan/ and room_labels/.'),
    ] = REAL_FOLDER,
    plot: Annotated[
        Path | None, typer.Option('--plot', metavar='FILE', help='Image of the distributions.')
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Compare generated storeys with hand-labelled real ones: percentiles and a classifier's AUC.

    Both are label rasters and are measured by the same code. The real storeys are those of the
    development split.

    Example: fpnet simulate stats --plot stats.png --json stats.json
    """
    import numpy as np

    from fpnet_lab.sim.plans import generate_plan
    from fpnet_lab.sim.population.comparison import (
        PERCENTILES,
        compare,
        percentile_errors,
        two_sample,
    )
    from fpnet_lab.sim.population.floors import floor_of_plan, read_floors
    from fpnet_lab.sim.population.statistics import measure_floor

    real = [measure_floor(floor) for floor in read_floors(common.check_input(data))]
    generated: list[FloorMeasures] = []
    for i in track(range(count), 'storeys'):
        storey = generate_plan(np.random.default_rng([seed or 0, i]))
        generated.append(measure_floor(floor_of_plan(storey, f'{storey.family}-{i}')))
    rows, told = compare(generated, real), two_sample(generated, real, seed or 0)
    if plot is not None:
        _plot(generated, real, plot)
    counts = {'generated': len(generated), 'real': len(real), 'at': PERCENTILES}
    finish('statistics', json_path, counts | _result(rows, percentile_errors(rows), told))
    features = sorted(told.importance, key=lambda name: -told.importance[name])
    common.say(
        f'\na classifier separates real from generated regions with AUC {told.auc:.2f} '
        f'(spread over folds {told.spread:.2f}); main features: {", ".join(features[:3])}',
        json_path,
    )


def _plot(generated: Sequence[FloorMeasures], real: Sequence[FloorMeasures], path: Path) -> None:
    from fpnet_lab.sim.population.comparison import QUANTITIES
    from fpnet_lab.viz.population import save_population

    def values(floors: Sequence[FloorMeasures]) -> dict[str, NDArray[np.float64]]:
        return {name: quantity(floors) for name, quantity in QUANTITIES.items()}

    save_population(values(generated), values(real), [values([floor]) for floor in real], path)


def _result(rows: Sequence[Row], errors: dict[str, float], told: TwoSample) -> dict[str, Any]:
    return {
        'percentile_error': errors,
        'regions_auc': told.auc,
        'regions_auc_spread': told.spread,
        'importance': told.importance,
        'percentiles': {row.name: {'generated': row.generated, 'real': row.real} for row in rows},
    }
