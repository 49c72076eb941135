# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Buildings that never were: floorplans, matching pairs, worlds and recordings.

Every function takes a generator or a seed; equal seeds give equal results on every machine.
Import what you need from the submodules: some load numba or Open3D.
"""
