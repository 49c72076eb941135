# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Every command of README and docs/cli.md is executed: here, or by the test that is named here.

A command that is neither run nor named fails, and so does an entry for one that is gone. Those of
the tutorial are followed word for word by ``test_walkthrough.py``.
"""

from pathlib import Path
import re
import shlex
import shutil

from documents import ROOT, commands
import numpy as np
from PIL import Image
import pytest

from fpnet.cli import main

DOCUMENTS = ('README.md', 'docs/cli.md')

_SMALL_NETWORK = '--epochs 1 --set network.width=8 --set network.layers=1'

RUN = {
    'fpnet plan my_plan.png --out out/plan.yaml': '',
    'fpnet doctor drive.bag': '',
    'fpnet check-plan my_plan.png --out out/check': '--tours 0',
    'fpnet localize drive.bag --floorplan out/plan.yaml --out out/run': '',
    'fpnet localize drive.bag --floorplan out/plan.yaml --film run.gif': '',
    'fpnet localize drive.bag --floorplan out/plan.yaml --view': '--port 0',
    'fpnet view out/run': '--port 0 --rate 0 --end',
    'fpnet view out/run --poster poster.png': '',
    'fpnet match --floorplan plan.png --submap robot_map.png --json match.json': '',
    'fpnet segment plan.png --plot regions.png': '',
    'fpnet simulate recording --out drive --seed 7 --sensor beams16': (
        '--floorplan my_plan.png --sensor planar'
    ),
    'fpnet simulate recording --out mine --floorplan my_plan.png': '--sensor planar',
    'fpnet simulate pairs --out pairs --count 2000 --seed 1': '--count 12',
    'fpnet train matcher --data pairs --out run': _SMALL_NETWORK,
    'fpnet train finetune --floorplan my_plan.png --out run': '--count 20 --epochs 1',
}
"""Commands that run here, with what is added to make them cheap."""

ELSEWHERE = {
    'make demo': 'test/ros/test_ros_demo.py::test_a_session_leaves_its_files_and_no_process',
    'make test': '.ci/run::make test-all',
    'colcon build --packages-select fpnet_ros': 'test/ros/conftest.py::colcon',
    'pip install .[plans,report]': 'test/integration/test_wheel.py::'
    'test_the_command_and_its_data_are_in_the_wheel',
    'fpnet demo --seed 3': 'test/ros/test_ros_demo.py::'
    'test_a_session_leaves_its_files_and_no_process',
    'ros2 launch fpnet_ros localizer.launch.py floorplan:=plan.yaml points:=/lidar/points': (
        'test/ros/test_ros_launch.py::test_nodes_exist_and_declare_what_they_are_given'
    ),
    'fpnet localize drive.bag --site site.yaml': 'test/integration/test_site_localize.py::'
    'test_a_drive_is_localised_on_its_storey',
    'fpnet diff drive.bag --floorplan plan.yaml --out out/diff': (
        'test/integration/test_site_localize.py::'
        'test_what_was_seen_is_matched_and_compared_on_its_storey'
    ),
    'fpnet align --floorplan plan.yaml --submap robot_map.yaml --out out/align': (
        'test/integration/test_align_cli.py::test_transform_is_right_to_a_few_centimetres'
    ),
    'fpnet site check site.yaml': 'test/integration/test_site_localize.py::'
    'test_site_check_says_what_looks_alike',
    'fpnet library find plans.lib --submap robot_map.yaml': (
        'test/integration/test_library_cli.py::'
        'test_a_library_is_built_and_names_the_building_that_was_seen'
    ),
    'fpnet simulate stats --plot stats.png': 'test/unit/cli/test_cli_simulate_plans.py::'
    'test_stats_compare_with_labelled_drawings',
    'fpnet bench segmentation': 'test/real/test_real_segmentation.py::'
    'test_benchmark_reports_fractions_for_plans_and_robot_maps',
    'fpnet bench matching': 'test/unit/evaluation/test_bench_matching.py::'
    'test_methods_are_scored_on_the_same_pairs',
    'fpnet bench localization': 'test/integration/test_bench_localization_case.py::'
    'test_the_command_reports_and_names_what_it_skipped',
    'fpnet bench calibration': 'test/integration/test_scorer_trials.py::'
    'test_the_benchmark_measures_what_is_packaged_and_draws_it',
    'fpnet bench open make': 'test/unit/evaluation/test_open_benchmark.py::'
    'test_generated_cases_hold_scans_whose_truth_is_on_the_walls',
    'fpnet bench open run': 'test/unit/evaluation/test_open_benchmark.py::'
    'test_own_programs_answer_the_same_twice_and_stand_side_by_side',
    'fpnet bench open score': 'test/unit/evaluation/test_open_benchmark.py::'
    'test_the_truth_is_right_and_its_claims_on_other_plans_are_counted',
    'fpnet bench simulator': 'test/unit/sim/test_sim_throughput.py::'
    'test_rates_are_what_was_made_over_the_time_that_it_took',
}
"""Commands that a test or CI executes elsewhere: file and what to find in it."""

DOCUMENTED = {command: name for name in DOCUMENTS for command in commands(name)}


def test_every_command_is_run_or_named():
    missing = {c: name for c, name in DOCUMENTED.items() if c not in RUN and c not in ELSEWHERE}
    assert missing == {}, 'run them here, or name the test that does'
    assert sorted({*RUN, *ELSEWHERE} - set(DOCUMENTED)) == [], 'no longer in the documents'


@pytest.mark.parametrize('place', sorted(set(ELSEWHERE.values())))
def test_named_tests_exist(place):
    path, _, what = place.partition('::')
    text = (ROOT / path).read_text(encoding='utf-8')
    assert re.search(rf'def {what}\b' if what.startswith('test_') else re.escape(what), text)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Hold the files that the documents' commands name, of a building of two rooms."""
    folder = tmp_path_factory.mktemp('documents')
    picture = np.full((140, 240), 178, np.uint8)
    picture[16:124, 16:224] = 0
    picture[20:120, 20:140] = 255
    picture[20:120, 144:220] = 255
    picture[60:80, 140:144] = 255
    for name in ('my_plan.png', 'plan.png'):
        Image.fromarray(picture).save(folder / name)
    robot_map = picture.copy()
    robot_map[:, 190:] = 178  # not seen yet
    Image.fromarray(robot_map).save(folder / 'robot_map.png')
    made = folder / 'made'
    words = ['simulate', 'recording', '--out', made, '--floorplan', folder / 'plan.png']
    assert call([*words, '--sensor', 'planar', '--wheels']) == 0
    shutil.copytree(made / 'bag', folder / 'drive.bag')
    shutil.copy(made / 'floorplan.yaml', folder / 'plan.yaml')
    shutil.copy(made / 'floorplan.png', folder)
    return folder


def call(words):
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return ended.value.code or 0


@pytest.mark.slow
def test_commands_do_what_they_say(folder, monkeypatch):
    """In the order of the documents, whose later commands use what earlier ones wrote."""
    monkeypatch.chdir(folder)
    for command in DOCUMENTED:
        if command in RUN:
            words = shlex.split(f'{command} {RUN[command]}')
            assert call(words[1:]) == 0, command
            for option in ('--out', '--plot', '--film', '--poster'):
                if option in words:
                    assert Path(words[words.index(option) + 1]).exists(), command
            shutil.rmtree('run', ignore_errors=True)  # train and finetune have the same folder
