# SPDX-License-Identifier: GPL-3.0-or-later
"""A process that exports .blend files for test_suite.py, since Blender cannot be started twice in one:

    python suite_scenes.py FOLDER SCENE.blend...

Writes NAME.nephele for each and prints {name: fingerprint}, as JSON.
"""

import json
import sys
from pathlib import Path

from nephele import description_file
from nephele.blend_source import BlendSource

folder, fingerprints = Path(sys.argv[1]), {}
for path in map(Path, sys.argv[2:]):
    with BlendSource(path, (16, 9)) as source:
        scene = source.export()
    description_file.save(folder / f"{path.stem}.nephele", scene)
    fingerprints[path.stem] = description_file.fingerprint(scene)
print(json.dumps(fingerprints))
