# SPDX-License-Identifier: GPL-3.0-or-later
# To compare others with: no early end, 1024 bounces. Takes hours.
import bpy

nephele = bpy.context.scene.nephele

nephele.samples = 16384
nephele.max_bounces = 1024
nephele.surface_bounces = 1024
nephele.volume_bounces = 1024
nephele.roulette_depth = 16
