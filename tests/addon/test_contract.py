# SPDX-License-Identifier: GPL-3.0-or-later
"""One declaration each: properties, passes, opcodes and closures agree with their tables and with Blender's
nodes."""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from nephele import opcodes, parameters, passes, properties
from nephele.export import blackbody, nodes, nodes_closure, nodes_fold, nodes_volume
from programs import with_nodes

ADDON = Path(__file__).resolve().parents[2] / "addon"


@pytest.mark.parametrize("parameter", parameters.PARAMETERS, ids=lambda p: p.name)
def test_scene_property_is_the_parameter(bpy, parameter):
    settings = bpy.context.scene.nephele
    rna = settings.bl_rna.properties[parameter.name]
    assert (rna.name, rna.description) == (parameter.label, parameter.tooltip)
    assert getattr(settings, parameter.name) == pytest.approx(parameter.default)
    if parameter.kind == "enum":
        assert [(i.identifier, i.name, i.description, i.value) for i in rna.enum_items] == [
            (*item, index) for index, item in enumerate(parameter.items)
        ]
    elif parameter.kind != "bool":
        assert rna.hard_min == pytest.approx(parameter.minimum)
        assert rna.hard_max == pytest.approx(parameter.maximum)
        if parameter.soft_maximum is not None:
            assert rna.soft_max == pytest.approx(parameter.soft_maximum)


def test_no_property_but_the_parameters(bpy):
    names = {p.identifier for p in bpy.context.scene.nephele.bl_rna.properties} - {"rna_type", "name"}
    assert names == set(parameters.BY_NAME)


def test_every_parameter_has_a_panel():
    from nephele import render_panels

    assert {p.group for p in parameters.PARAMETERS} <= {row[0] for row in render_panels.GROUPS}


def test_settings_survive_saving(bpy, tmp_path):
    bpy.context.scene.nephele.samples = 77
    bpy.context.view_layer.nephele.use_pass_cost = True
    path = str(tmp_path / "settings.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert bpy.context.scene.nephele.samples == 77
    assert bpy.context.view_layer.nephele.use_pass_cost
    assert bpy.context.scene.render.engine == "NEPHELE"


@pytest.mark.parametrize("row", passes.PASSES, ids=lambda p: p.identifier)
def test_every_pass_has_one_toggle(bpy, row):
    layer = bpy.context.view_layer
    assert hasattr(layer, row.view_layer or properties.toggle_name(row)) == bool(row.view_layer)
    assert hasattr(layer.nephele, properties.toggle_name(row)) != (bool(row.view_layer) or row.denoised)
    assert not row.cycles or hasattr(layer.cycles, row.cycles)
    assert len(row.channels) in (1, 3, 4)  # Blender cannot store two


def test_folded_operations_exist():
    assert set(nodes_fold.FOLD) <= set(opcodes.OPCODES)
    assert set(nodes_fold.BLEND) == set(opcodes.BLEND_MODES)


def test_what_operations_read_is_what_they_say():
    """`needs`, the checks of programs and the keys of a scene's parts go by opcodes.READS."""
    said = {
        "image": "image number",
        "uv": "UV map number",
        "attribute": "mesh attribute number",
        "property": "property number",
        "camera": "camera",
    }
    for kind, words in said.items():
        names = {name for name, text in opcodes.OPCODES.items() if words in text}
        assert names <= set(opcodes.READS[kind]) <= set(opcodes.OPCODES), kind
    assert set(opcodes.READS["camera"]) >= {name for name, text in opcodes.OPCODES.items() if "pixel" in text}


def test_operations_not_folded_need_the_shading_point_or_data():
    start = list(opcodes.OPCODES)
    inputs = set(start[: start.index("image")])
    known = {
        "image",
        "image_alpha",
        "environment",
        "environment_mirror_ball",
        "checker",
        "checker_fac",
        "grid",
        "noise",
        "voronoi",
        "white_noise",
        "gabor",
        "brick",
        "sphere_projection",
        "tube_projection",
        "box_projection",
    }
    shading = {"gradient", "fresnel", "layer_weight", "normal_map", "convert_space", "bump", "wireframe"}
    assert set(opcodes.OPCODES) - set(nodes_fold.FOLD) == inputs | known | shading


def test_blackbody_is_the_native_one():
    """Both halves integrate the same observer at the same temperatures."""
    source = (ADDON.parent / "native" / "shading" / "color_math.cpp").read_text(encoding="utf-8")
    rows = re.search(r"kObserver\[\]\[3\] = \{(.*?)\};", source, re.DOTALL).group(1)
    native = np.array([float(number) for number in re.findall(r"\d+\.\d+", rows)]).reshape(-1, 3)
    assert np.array_equal(native, blackbody.OBSERVER)
    assert f"kLow = {blackbody.LOWEST_K:g}, kStep = {blackbody.STEP_K:g};" in source
    assert f"std::array<Rgb, {len(blackbody.TEMPERATURES)}> table" in source
    assert len(blackbody.WAVELENGTHS) == len(native)


def node_types(bpy):
    """Returns node type ("BSDF_GLASS") -> node of every shader node of this Blender."""
    tree = with_nodes(bpy.data.materials.new("Nodes")).node_tree
    found = {}
    for name in dir(bpy.types):
        if name.startswith("ShaderNode"):
            try:
                node = tree.nodes.new(name)
            except RuntimeError:  # an abstract type
                continue
            found[node.type] = node
    return found


def test_handled_node_types_exist(bpy):
    found = set(node_types(bpy))
    absent = {"SEPRGB", "COMBRGB", "SEPHSV", "COMBHSV", "INVERT_COLOR"}  # of older Blenders
    if bpy.app.version < (5, 0, 0):
        absent.add("VOLUME_COEFFICIENTS")
    handled = set(nodes.VOLUME_HANDLERS) | set(nodes_closure.SIMPLE) | set(nodes_volume.NODES)
    assert handled - absent <= found


@pytest.mark.parametrize("kind", nodes_closure.SIMPLE)
def test_closure_inputs_are_sockets(bpy, kind):
    names = {socket.identifier for socket in node_types(bpy)[kind].inputs}
    closure = nodes_closure.SIMPLE[kind]
    assert {nodes_closure.socket_name(name) for name in opcodes.CLOSURES[closure]} - names == set()


def test_registering_does_not_load_the_native_module():
    """In a process left without Python's own exit, at which the bpy module of Blender 4.2 crashes."""
    code = (
        "import os, sys; sys.path.insert(0, sys.argv[1]); import conftest, nephele;"
        "nephele.register(); nephele.unregister(); nephele.register(); nephele.unregister();"
        "os._exit('nephele_native' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code, str(ADDON.parent / "tests")], check=True, timeout=60)


def test_unregistering_leaves_nothing(bpy, addon):
    """Nothing of ours may remain in Blender's types and panels."""
    panel = bpy.types.RENDER_PT_output
    assert "NEPHELE" in panel.COMPAT_ENGINES
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"
    addon.unregister()
    try:
        assert "NEPHELE" not in panel.COMPAT_ENGINES
        assert not hasattr(bpy.context.scene, "nephele")
        assert not [name for name in dir(bpy.types) if name.startswith(("NEPHELE_PT", "NEPHELE_OT"))]
    finally:
        addon.register()


def imports_of(path):
    """Returns the names of what a module imports, relative ones with their dots."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (node.module or "")
            yield from ([base] if node.module else [base + alias.name for alias in node.names])


@pytest.mark.parametrize("path", sorted((ADDON / "export").glob("*.py")), ids=lambda p: p.name)
def test_exporter_imports_neither_panels_nor_native(path):
    forbidden = {"..panels", "..bridge", "..engine", "..properties", "nephele_native"}
    assert not forbidden & set(imports_of(path))


@pytest.mark.parametrize("name", ["description", "opcodes", "parameters", "passes"])
def test_contract_knows_neither_bpy_nor_native(name):
    assert set(imports_of(ADDON / f"{name}.py")) <= {"dataclasses", "numpy"}


def test_manifest():
    """What `blender --command extension validate` asks for."""
    manifest = tomllib.loads((ADDON / "blender_manifest.toml").read_text())
    assert {"schema_version", "id", "version", "name", "tagline", "maintainer", "type", "license"} <= set(
        manifest
    )
    assert manifest["blender_version_min"] == "4.2.0"
    for text in (manifest["tagline"], *manifest["permissions"].values()):
        assert len(text) <= 64
        assert text[-1].isalnum()
    assert set(manifest["permissions"]) <= {"files", "network", "clipboard", "camera", "microphone"}


def test_version_is_the_same_everywhere():
    manifest = tomllib.loads((ADDON / "blender_manifest.toml").read_text())
    project = tomllib.loads((ADDON.parent / "pyproject.toml").read_text())
    assert manifest["version"] == project["project"]["version"]


def test_hsv_agrees_with_the_standard_library():
    import colorsys

    rng = np.random.default_rng(1)
    for rgb in rng.random((200, 3)):
        assert np.allclose(nodes_fold.rgb_to_hsv(rgb), colorsys.rgb_to_hsv(*rgb))
        assert np.allclose(nodes_fold.hsv_to_rgb(nodes_fold.rgb_to_hsv(rgb)), rgb)
        hsl = nodes_fold.FOLD["rgb_to_hsl"](rgb, parameters=(), mode=0)
        h, l, s = colorsys.rgb_to_hls(*rgb)
        assert np.allclose(hsl, (h, s, l))
        assert np.allclose(nodes_fold.FOLD["hsl_to_rgb"](hsl, parameters=(), mode=0), rgb)


def test_the_page_of_passes_is_up_to_date():
    root = Path(passes.__file__).resolve().parents[1]
    made = subprocess.run(
        [sys.executable, "-c", "import generate_pass_page as g; print(g.page(), end='')"],
        cwd=root / "tools", capture_output=True, text=True, check=True,
    )  # fmt: skip
    page = (root / "docs" / "passes.md").read_text(encoding="utf-8")
    assert made.stdout == page, "run tools/generate_pass_page.py"
