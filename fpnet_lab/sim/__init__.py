# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Simulated buildings: floorplans, matching pairs, worlds and recordings.

Every function takes a random generator or a seed; equal seeds give equal results on every
machine. Import from the submodules that you need: some of them load numba or Open3D.
"""
