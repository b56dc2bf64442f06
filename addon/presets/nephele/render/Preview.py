# SPDX-License-Identifier: GPL-3.0-or-later
# A quick look: noisy, and darker than it will be deep inside clouds.
import bpy

nephele = bpy.context.scene.nephele

nephele.samples = 16
nephele.max_bounces = 16
