# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The page and the picture of a floorplan check."""

import re

from PIL import Image

from fpnet.plan_check.check import PlanCheck, TourResult
from fpnet.plan_check.self_similarity import SelfSimilarity, Twin
from fpnet.plan_check.verdict import Fitness, PlanVerdict, Reason
from fpnet.report.plan_page import write_plan_report
from fpnet.viz.plan_check import UNIQUE, save_plan_check, similarity_colours
from fpnet_core.drawings.types import DrawingScale, ScaleSource
from fpnet_core.segmentation import ScaleEstimate

TWIN = Twin(0, 3, 180.0, 0.97)


def test_the_page_holds_advice_rooms_and_drives(made_up_run, tmp_path):
    check = PlanCheck(
        made_up_run.plan,
        ScaleEstimate(1.25, 1.1, 1.4),
        DrawingScale(0.05, 0.04, 0.06, ScaleSource.ESTIMATED),
        SelfSimilarity({0: (TWIN,)}, {}, ()),
        (TourResult(7, 40.0, 6.5, 0.1), TourResult(8, 41.0, None, None)),
        advice=('Draw <doors> open.',),
        verdict=PlanVerdict(Fitness.DOUBTFUL, (Reason('it has no <door>', 'fpnet plan a.png'),)),
    )
    write_plan_report(tmp_path / 'new' / 'report.html', 'a & b.png', check)
    text = (tmp_path / 'new' / 'report.html').read_text(encoding='utf-8')
    assert 'Draw &lt;doors&gt; open.' in text
    assert '<h2>Doubtful</h2>' in text
    assert 'it has no &lt;door&gt;.<br>Next: <code>fpnet plan a.png</code>' in text
    assert 'Floorplan check: a &amp; b.png' in text
    assert 'from inside, looks like room 3' in text
    assert re.search(r'<td>8</td><td>41.0</td>\s*<td>not localized</td>', text)
    assert 'src=' not in text.split('</style>')[0]


def test_colours_and_picture(made_up_run, tmp_path):
    plan = made_up_run.plan
    colours = similarity_colours(plan, SelfSimilarity({0: (TWIN,), 1: (TWIN,)}, {1: (TWIN,)}, ()))
    assert len({colours[0], colours[1], colours[2]}) == 3
    assert colours[2] == UNIQUE
    save_plan_check(tmp_path / 'new' / 'plan.png', plan, SelfSimilarity({0: (TWIN,)}, {}, ()))
    assert Image.open(tmp_path / 'new' / 'plan.png').width > 900
