# SPDX-License-Identifier: GPL-3.0-or-later
# A quick look: noisy, but with all the light of a final image.
import bpy

nephele = bpy.context.scene.nephele

nephele.samples = 16
