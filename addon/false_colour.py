# SPDX-License-Identifier: GPL-3.0-or-later
"""False colour: numbers as colours whose lightness grows with the number.

Both ramps are made in OKLCh (B. Ottosson, 2020, "A perceptual color space for image processing"), chroma
reduced to what sRGB holds, and stored as 8-bit sRGB at equal distances: SEQUENTIAL goes up in lightness from
violet to yellow, DIVERGING from blue over a light grey in the middle to rust, as dark at both ends. Knows
numpy alone.
"""

from dataclasses import dataclass

import numpy as np

SEQUENTIAL = (
    (20, 0, 43), (34, 0, 79), (45, 9, 116), (49, 39, 142), (39, 70, 158), (4, 103, 156), (4, 129, 155),
    (0, 155, 157), (0, 181, 150), (35, 208, 116), (144, 223, 75), (211, 233, 67), (255, 242, 166),
)  # fmt: skip
DIVERGING = (
    (1, 57, 116), (20, 84, 157), (68, 115, 175), (110, 146, 192), (152, 176, 208), (194, 207, 223),
    (238, 238, 238),
    (222, 200, 193), (205, 163, 149), (186, 127, 106), (165, 90, 63), (143, 51, 11), (103, 31, 0),
)  # fmt: skip
NOT_FINITE = (255, 0, 255)  # on neither ramp


@dataclass(frozen=True)
class Scale:
    """Numbers from low to high as positions from 0 to 1 on a ramp; those beyond take the colour of its end.

    logarithmic: equal ratios are equal distances (0 < low). diverging: low is -high, the middle is 0.
    """

    low: float
    high: float
    logarithmic: bool = False
    diverging: bool = False

    @property
    def ramp(self):
        """The colours, 8-bit sRGB at equal distances."""
        return DIVERGING if self.diverging else SEQUENTIAL

    def position(self, values):
        """Returns where `values` are on the ramp, in [0, 1]; NaN where they are not finite."""
        values = np.where(np.isfinite(values), values, np.nan).astype(float)
        low, high = self.low, self.high
        if self.logarithmic:
            values, low, high = np.log(np.maximum(values, low)), np.log(low), np.log(high)
        return np.clip((values - low) / (high - low), 0, 1)

    def value(self, position):
        """Returns the numbers at positions on the ramp."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** position
        return self.low + (self.high - self.low) * position

    def text(self):
        """Returns what the ends of the ramp stand for."""
        ends = ("blue", "rust") if self.diverging else ("dark", "bright")
        kind = ", logarithmic" if self.logarithmic else ""
        return f"{self.low:.3g} ({ends[0]}) to {self.high:.3g} ({ends[1]}){kind}"

    def colours(self, values):
        """Returns `values`, of any shape, as 8-bit sRGB with one axis more."""
        position = self.position(values)
        at = np.linspace(0, 1, len(self.ramp))
        channels = [np.interp(position, at, channel) for channel in np.transpose(self.ramp)]
        colours = np.rint(np.nan_to_num(np.stack(channels, axis=-1))).astype(np.uint8)
        colours[np.isnan(position)] = NOT_FINITE
        return colours


def encoded(radiance):
    """Returns linear sRGB as 8-bit sRGB, clipped at 1; NOT_FINITE where a channel is not finite."""
    clipped = np.clip(np.nan_to_num(radiance), 0, 1)
    curve = np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)
    colours = np.rint(255 * curve).astype(np.uint8)
    colours[~np.isfinite(radiance).all(axis=-1)] = NOT_FINITE
    return colours
