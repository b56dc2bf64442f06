# SPDX-License-Identifier: GPL-3.0-or-later
# Up to 1024 samples; stops earlier where the estimated error is low.
import bpy

nephele = bpy.context.scene.nephele

nephele.samples = 1024
nephele.target_error = 0.002
