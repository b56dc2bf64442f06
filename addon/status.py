# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's status lines say while Nephele renders. Knows no bpy."""


def status_text(progress):
    """Returns "Sample 3/128 | 0:05 | Error 0.021 | 3:20 left" of Renderer.progress()."""
    text = f"Sample {progress['samples_done']}/{progress['samples']} | {clock(progress['seconds'])}"
    if progress["error"] is not None:
        text += f" | Error {progress['error']:.2g}"
    if 0 < progress["fraction"] < 1:
        left = progress["seconds"] * (1 - progress["fraction"]) / progress["fraction"]
        text += f" | {clock(left)} left"
    return text


def clock(seconds):
    """Returns "m:ss", or "h:mm:ss" from an hour on."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
