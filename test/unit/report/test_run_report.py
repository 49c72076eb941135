# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The HTML report of a run: its values, its file, and its page in a real browser."""

import base64
from dataclasses import replace
import gzip
from html.parser import HTMLParser
import json
import re

from browser import open_page, wait_for
import numpy as np
from planted import A_PLAN_SUBMAP
import pytest

from fpnet.report import write_run_report
from fpnet.report.charts import plan_figure
from fpnet.report.moments import MAX_MOMENTS, chosen_updates, ellipse, moments
from fpnet.report.pictures import grid_picture
from fpnet.report.record import (
    best_placement_error,
    on_one_storey,
    path_quality,
    published_errors,
)
from fpnet_core.differences import Difference, DifferenceKind, Differences
from fpnet_core.geometry import SE2
from fpnet_core.pose_covariance import Growth, PoseCovariance, PoseFeatures
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import OCCUPIED, Cause, CauseKind, GridMap, LocalizerOutput, Status

MAX_BYTES = 3_000_000
MOVING = ('placement_0', 'placement_2', 'near', 'ellipse', 'published', 'robot', 'door_names')


class Page(HTMLParser):
    """What a page loads, its elements, and what its script unpacks."""

    def __init__(self, text):
        super().__init__()
        self.loaded, self.elements, self.attributes = [], [], {}
        self.content, self._is_content = {}, False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.elements.append((tag, attributes))
        self.attributes[attributes.get('id')] = attributes
        self.loaded += [attributes[a] for a in ('src', 'href') if attributes.get(a)]
        self._is_content = attributes.get('id') == 'content'

    def handle_data(self, data):
        if self._is_content:
            self.content = json.loads(gzip.decompress(base64.b64decode(data)))
            self._is_content = False


@pytest.fixture(scope='module')
def report(made_up_run, tmp_path_factory):
    path = tmp_path_factory.mktemp('report') / 'new' / 'report.html'
    write_run_report(path, made_up_run)
    return path


@pytest.fixture(scope='module')
def page(report):
    return Page(report.read_text(encoding='utf-8'))


def test_it_is_one_file_that_loads_nothing(report, page):
    assert [url for url in page.loaded if not url.startswith(('data:', '#'))] == []
    assert report.stat().st_size < MAX_BYTES
    text = report.read_text(encoding='utf-8')
    assert 'a &lt;drive&gt; on a plan' in text
    assert 'a <drive>' not in text


def test_it_answers_at_a_glance_and_folds_the_rest(made_up_run, tmp_path):
    figures = {
        'path_to_first_pose_m': 3.25, 'time_to_first_pose_s': 7.0, 'wrong_poses': 0, 'poses': 9,
        'median_position_error_m': 0.031, 'median_yaw_error_deg': None, 'tick_ms_p50': 51.2,
        'tick_ms_p95': 80.0, 'sigma_position_m_median': 0.12, 'scans': 40, 'is_odd': True,
    }  # fmt: skip
    path = tmp_path / 'report.html'
    write_run_report(path, replace(made_up_run, figures=figures, building='Annex', title='drive'))
    text = path.read_text(encoding='utf-8')
    assert '<h1>Annex</h1>' in text, 'a second after 1970 is no date'
    assert '>Localized at 3.2 m (7 s), p 0.90, error 0.03 m</b>' in text
    tiles = re.findall('<dt>(.*?)</dt><dd>(.*?)</dd>', text)
    assert len(tiles) == 5
    assert ('poses', '9, 0 wrong') in tiles
    assert ('update, median', '51 ms') in tiles
    folded = text.partition('<summary>All figures')[2]
    assert '<td>update, 95th percentile [ms]</td><td>80.00</td>' in folded
    assert '<td>is odd</td><td>yes</td>' in folded
    assert 'yaw error' not in folded
    lost = replace(made_up_run.outputs[2], status=Status.LOST, A_plan_odom=None)
    write_run_report(path, replace(made_up_run, outputs=(lost,)))
    assert 'Localized at 3.2 m, but lost at the end, p 0.90' in path.read_text(encoding='utf-8')


def test_the_title_has_the_date_and_rooms_the_names_of_the_drawing(made_up_run, tmp_path):
    names = {made_up_run.plan.rooms[1].id: 'Lab 2'}
    traces = {t.name: t for t in plan_figure(replace(made_up_run, room_names=names)).data}
    assert 'Lab 2' in traces['room names'].text
    outputs = (replace(made_up_run.outputs[0], stamp_ns=1_700_000_000 * 10**9),)
    nothing = PlanarTrajectory.empty()
    dated = replace(made_up_run, outputs=outputs, published=nothing, truth=None, building='Annex')
    assert dated.heading_line == 'Annex, 2023-11-14'


def test_the_path_has_the_colours_of_errors_or_of_standard_deviations(made_up_run, page):
    assert page.content['data']['published']['quality_m'] == pytest.approx([0.05, 0.05], abs=1e-3)
    steady, features = Growth(0.0, 0.0, 0.0, 0.0), PoseFeatures(np.eye(3), np.zeros(1))
    last = made_up_run.outputs[2]
    at = np.array([1.0, 2.0])
    cov = PoseCovariance(np.diag([0.09, 0.16, 0.01]), at, last.stamp_ns, steady, features)
    known = replace(last, covariance=cov)
    untold = replace(made_up_run, truth=None, outputs=(*made_up_run.outputs[:2], known))
    name, values = path_quality(untold)
    assert name == 'standard deviation'
    assert values == pytest.approx([0.5, 0.5])
    corners = ellipse(known) - last.A_plan_odom.apply(at)
    assert np.abs(corners).max(axis=0) == pytest.approx(
        np.sqrt(5.991) * np.array([0.3, 0.4]), rel=1e-2
    )
    assert len(ellipse(last)) == 0


def test_the_submap_is_turned_to_the_plan_and_its_last_walls_are_where_the_pose_is(page):
    waiting, _, localized = page.content['data']['moments']
    assert waiting['turn'] == 0.0
    assert localized['turn'] == pytest.approx(A_PLAN_SUBMAP.heading, abs=1e-3)
    assert waiting['A_plan_near'] is None
    np.testing.assert_allclose(localized['A_plan_near'], A_PLAN_SUBMAP.matrix[:2], atol=1e-4)


def test_there_is_a_moment_for_each_tick(page):
    moments = page.content['data']['moments']
    assert [m['status'] for m in moments] == ['waiting', 'ambiguous', 'localized']
    assert [m['reason'] for m in moments] == [f'{k} placements' for k in (0, 2, 3)]
    assert [m['time_s'] for m in moments] == [0.0, 1.0, 2.0]
    assert page.attributes['slider']['max'] == '2'
    assert moments[0]['placements'] == []
    assert moments[0]['picture'] is None
    assert [p['score'] for p in moments[2]['placements']] == [0.9, 0.3, 0.2]
    assert [p['is_claimed'] for p in moments[2]['placements']] == [True, False, False]
    assert moments[2]['timings_ms']['align'] == 30.0
    assert moments[1]['picture']['source'].startswith('data:image/png;base64,')


def test_matches_join_plan_and_submap_regions(page, made_up_run):
    match = page.content['data']['moments'][1]['matches'][0]
    plan, sub = made_up_run.plan, made_up_run.outputs[1].segmentation
    assert match['plan_xy'] == pytest.approx(plan.regions[match['plan_id']].centroid, abs=0.01)
    assert match['sub_xy'] == pytest.approx(sub.regions[match['sub_id']].centroid, abs=0.01)


def test_what_was_found_on_another_storey_is_not_drawn_on_this_one(made_up_run):
    first, second, last = made_up_run.outputs
    elsewhere = [first, replace(second, storey='below'), replace(last, storey='above')]
    record = replace(made_up_run, outputs=on_one_storey(elsewhere))
    below, above = moments(record)[1:]
    assert (below['placements'], below['matches'], below['labels']) == ([], [], [])
    assert below['reason'] == second.reason
    assert above == moments(made_up_run)[2]


def test_every_trace_that_the_script_moves_is_there(page):
    by_name = {
        name: {trace.get('meta') for trace in page.content['figures'][name]['data']}
        for name in ('plan', 'submap')
    }
    assert set(MOVING) <= by_name['plan']
    assert {'doors', 'path', 'robot', 'labels', 'door_names'} <= by_name['submap']
    assert page.content['figures']['timeline']['layout']['shapes'][0]['type'] == 'line'


def test_every_change_of_the_status_says_why(made_up_run, tmp_path):
    statuses = [Status.SEARCHING] * 200 + [Status.AMBIGUOUS] + [Status.SEARCHING] * 100
    outputs = tuple(
        LocalizerOutput(k, status, reason=f'because of {k}') for k, status in enumerate(statuses)
    )
    write_run_report(tmp_path / 'long.html', replace(made_up_run, outputs=outputs))
    page = Page((tmp_path / 'long.html').read_text(encoding='utf-8'))
    told = [(c['status'], c['reason']) for c in page.content['data']['changes']]
    assert told == [
        ('searching', 'because of 0'),
        ('ambiguous', 'because of 200'),
        ('searching', 'because of 201'),
    ]


def test_doors_and_rooms_are_numbered_as_the_table_names_them(page):
    moment = page.content['data']['moments'][1]
    doors = [match for match in moment['matches'] if match['is_door']]
    rooms = {f'{m["sub_id"]}→{m["plan_id"]}' for m in moment['matches'] if not m['is_door']}
    assert doors
    assert {label[2] for label in moment['labels']} == rooms


def test_the_robot_looks_where_odometry_says_or_where_it_went(made_up_run):
    output = made_up_run.outputs[2]
    step = output.submap.path_xy[-1] - output.submap.path_xy[-2]
    assert made_up_run.heading(output) == pytest.approx(np.arctan2(step[1], step[0]))
    stamp, turn = output.submap.stamp_ns, output.submap.T_odom_submap.yaw
    stamps = np.array([stamp - 10**8, stamp])
    odometry = PlanarTrajectory(stamps, np.zeros((2, 2)), np.array([0.0, 2.0]))
    turned = replace(made_up_run, odometry=odometry)
    assert turned.heading(output) == pytest.approx(2.0 - turn)
    assert made_up_run.heading(made_up_run.outputs[0]) is None


def contrast(one, other):
    """The contrast of two sRGB colours by WCAG 2, in its own words."""

    def luminance(colour):
        channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


def test_errors_are_in_true_metres(made_up_run):
    errors = published_errors(made_up_run)
    assert errors.position_m == pytest.approx([0.05, 0.05])
    assert errors.yaw_deg == pytest.approx([0.0, 0.0], abs=1e-6)
    found = [best_placement_error(made_up_run, output) for output in made_up_run.outputs]
    assert found == [None, *[pytest.approx(0.05, abs=1e-3)] * 2]


def test_a_run_without_truth_poses_or_ticks_has_a_report(made_up_run, tmp_path):
    nothing = PlanarTrajectory(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros(0))
    bare = replace(made_up_run, outputs=(), published=nothing, truth=None)
    write_run_report(tmp_path / 'bare.html', bare)
    page = Page((tmp_path / 'bare.html').read_text(encoding='utf-8'))
    assert page.content['data']['moments'] == []
    layout = page.content['figures']['timeline']['layout']
    titles = [axis['title']['text'] for name, axis in layout.items() if name.startswith('yaxis')]
    assert titles == ['probability', 'update [ms]'], 'no errors without a truth'


def test_long_runs_are_thinned_out_but_changes_stay():
    statuses = [Status.SEARCHING] * 501 + [Status.AMBIGUOUS] + [Status.SEARCHING] * 600
    chosen = chosen_updates([status.value for status in statuses])
    assert len(chosen) <= MAX_MOMENTS
    assert {0, 501, 502, len(statuses) - 1} <= set(chosen)
    assert chosen == sorted(set(chosen))


def test_pictures_lie_where_their_grid_does():
    cells = np.zeros((40, 60), np.int8)
    cells[30:34, 10:14] = OCCUPIED
    grid = GridMap(cells, 0.1, SE2.from_xy_yaw(5.0, -3.0, np.deg2rad(90.0)))
    red = np.zeros((40, 60, 3), np.uint8)
    red[cells == OCCUPIED] = (255, 0, 0)
    picture = grid_picture(grid, red, 400)
    # Turned by a quarter: the grid's 6 m along x now go along y, its 4 m along -x.
    corner = (picture.x, picture.y, picture.width, picture.height)
    assert corner == pytest.approx((1.0, 3.0, 4.0, 6.0))
    rows, columns = np.nonzero(decoded(picture)[..., 0] > 128)
    x = picture.x + (columns.mean() + 0.5) * 0.1
    y = picture.y - (rows.mean() + 0.5) * 0.1
    expected = grid.rc_to_xy([31.5, 11.5])
    assert (x, y) == pytest.approx(expected, abs=0.051)


def decoded(picture):
    import io

    from PIL import Image

    data = base64.b64decode(picture.uri.split(',', 1)[1])
    return np.asarray(Image.open(io.BytesIO(data)).convert('RGBA'))


@pytest.mark.apart
def test_the_slider_moves_everything_in_a_browser(report, made_up_run):
    with open_page(report) as browser:
        wait_for(browser, "document.body.dataset.ready === 'true'")

        def trace(chart, key, axis):
            return browser.execute_script(
                'const t = document.getElementById(arguments[0]).data'
                '.find((t) => t.meta === arguments[1]); return Array.from(t[arguments[2]]);',
                chart,
                key,
                axis,
            )

        def go_to(index):
            browser.execute_script(
                "const s = document.getElementById('slider'); s.value = arguments[0];"
                "s.dispatchEvent(new Event('input'));",
                index,
            )

        def text(element):
            return browser.execute_script(
                'return document.getElementById(arguments[0]).textContent', element
            )

        assert text('status') == 'localized'
        path = made_up_run.outputs[2].submap.path_xy
        expected = A_PLAN_SUBMAP.apply(path[-1])
        robot = [trace('plan', 'robot', axis)[0] for axis in 'xy']
        assert robot == pytest.approx(expected, abs=0.02)
        assert len(trace('plan', 'published', 'x')) == 2
        assert len(made_up_run.outputs[2].estimates) > 1
        assert len(trace('plan', 'placement_0', 'x')) > 100
        assert trace('plan', 'placement_1', 'x') == [], 'runners-up of an accepted placement'
        go_to(1)
        assert text('status') == 'ambiguous'
        assert 'error of the best placement 0.05 m' in text('facts')
        assert len(trace('plan', 'placement_1', 'x')) > 100
        assert trace('plan', 'placement_2', 'x') == []
        assert len(trace('submap', 'path', 'x')) == 3
        go_to(0)
        assert text('status') == 'waiting'
        assert trace('plan', 'placement_0', 'x') == []
        browser.execute_script("document.getElementById('play').click()")
        wait_for(browser, "document.getElementById('slider').value === '2'")
        arrow = browser.execute_script(
            "const t = document.getElementById('submap').data.find((t) => t.meta === 'robot');"
            'return [t.marker.symbol, t.marker.angle];'
        )
        heading = made_up_run.heading(made_up_run.outputs[2]) + A_PLAN_SUBMAP.heading
        assert arrow == ['arrow', pytest.approx(90.0 - np.rad2deg(heading), abs=0.1)]
        assert text('changes').count('placements') == 3
        for at, status in (('#t=1.2', 'ambiguous'), ('#t=2', 'localized')):
            browser.execute_script('location.hash = arguments[0]', at)
            wait_for(browser, f"document.getElementById('status').textContent === '{status}'")
        space = "new KeyboardEvent('keydown', {key: ' ', bubbles: true, cancelable: true})"
        go_to(0)
        browser.execute_script(f'document.body.dispatchEvent({space})')
        assert text('play') == 'Pause'
        wait_for(browser, "document.getElementById('slider').value === '2'")
        browser.execute_script(f'document.body.dispatchEvent({space})')
        browser.execute_script(f'document.body.dispatchEvent({space})')
        assert text('play') == 'Play'
        browser.execute_script("document.querySelector('#changes button').click()")
        assert text('status') == 'waiting'
        go_to(2)
        drawn = browser.execute_script(
            "return document.querySelectorAll('#plan .main-svg image, #submap image').length"
        )
        assert drawn == 2
        browser.execute_script('printed(true)')
        assert_fits(browser, 'plan')
        browser.execute_script('printed(false)')
        sheet = browser.execute_cdp_cmd('Page.printToPDF', {'preferCSSPageSize': True})
        assert base64.b64decode(sheet['data']).count(b'/Type /Page\n') == 1
        assert [entry for entry in browser.get_log('browser') if entry['level'] == 'SEVERE'] == []


def assert_fits(browser, name):
    width = browser.execute_script(
        "return document.querySelector('#' + arguments[0] + ' .main-svg').clientWidth", name
    )
    assert width <= 700


@pytest.mark.apart
@pytest.mark.parametrize('scheme', ['light', 'dark'])
def test_a_phone_shows_it_without_scrolling_sideways(report, scheme):
    with open_page(report) as browser:
        browser.execute_cdp_cmd(
            'Emulation.setDeviceMetricsOverride',
            {'width': 390, 'height': 844, 'deviceScaleFactor': 2, 'mobile': True},
        )
        browser.execute_cdp_cmd(
            'Emulation.setEmulatedMedia',
            {'features': [{'name': 'prefers-color-scheme', 'value': scheme}]},
        )
        browser.get(report.resolve().as_uri())
        wait_for(browser, "document.body.dataset.ready === 'true'")
        wide, ink = browser.execute_script(
            'return [document.documentElement.scrollWidth,'
            " document.getElementById('timeline').layout.font.color]"
        )
        assert wide == 390
        legend, chart = browser.execute_script(
            "return ['#plan .legend', '#plan'].map("
            '(name) => document.querySelector(name).getBoundingClientRect().height)'
        )
        assert 0 < legend < chart / 4, 'the floorplan needs the room'
        paper = '#161b22' if scheme == 'dark' else '#ffffff'
        assert contrast(ink, paper) >= 4.5
        assert [entry for entry in browser.get_log('browser') if entry['level'] == 'SEVERE'] == []


def test_a_run_without_a_pose_names_its_causes(made_up_run, report, tmp_path):
    causes = (Cause(CauseKind.MIRRORED, 'fits <flipped>', 'fpnet localize a --mirrored'),)
    write_run_report(tmp_path / 'report.html', replace(made_up_run, causes=causes))
    text = (tmp_path / 'report.html').read_text(encoding='utf-8')
    assert '<b>floorplan mirrored</b>: fits &lt;flipped&gt;.' in text
    assert '<code>fpnet localize a --mirrored</code>' in text
    assert 'Likely causes' not in report.read_text(encoding='utf-8')


def test_what_differs_from_the_drawing_lies_on_the_floorplan(made_up_run):
    def piece(kind, confidence):
        return Difference(kind, np.array([[1.0, 2.0], [3.0, 2.0]]), 2.0, confidence, np.zeros(1))

    pieces = (
        piece(DifferenceKind.WALL, 0.9),
        piece(DifferenceKind.FURNITURE, 0.8),
        piece(DifferenceKind.MISSING, 0.3),
    )
    grid = made_up_run.plan.grid
    none = np.zeros(grid.shape, dtype=np.int32)
    found = Differences(grid, pieces, none, none > 0)
    traces = plan_figure(replace(made_up_run, differences=found)).data
    shown = {trace.name: trace for trace in traces}
    assert 'drawn wall not there' not in shown
    assert shown['furniture'].visible == 'legendonly'
    wall = shown['wall not drawn']
    np.testing.assert_allclose(wall.x[:2], [1.0, 3.0])
    assert wall.hovertext[0] == 'wall not drawn, 2.0 m, 90 %'
    assert 'wall not drawn' not in {trace.name for trace in plan_figure(made_up_run).data}
