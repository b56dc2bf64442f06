# SPDX-License-Identifier: GPL-3.0-or-later
# The same work on every machine: 128 samples in every pixel, and the error told.
import bpy

nephele = bpy.context.scene.nephele

nephele.samples = 128
nephele.adaptive_sampling = False
nephele.estimate_error = True
