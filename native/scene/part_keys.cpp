// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/part_keys.h"

namespace nephele {

void add_to(PartKey& key, const Image& image) {
    key.add(image.width).add(image.height).add(image.bytes).add(image.floats).add(image.srgb);
}

void add_to(PartKey& key, const Program& program, const TextureContext& context) {
    key.add(program.registers.size());
    for (const Vec3f r : program.registers)
        key.add(r);
    key.add(std::span(program.code)).add(std::span(program.parameters)).add(program.closures.size());
    for (const ClosureRow& row : program.closures)
        key.add(row.kind).add(row.weight).add(row.mode).add(std::span(row.inputs));
    key.add(context.origin);
    bool sees_camera = false;
    for (const Instruction& i : program.code) {
        const Op op = static_cast<Op>(i.op);
        if (reads_image(op)) {
            const float number = program.parameters[static_cast<std::size_t>(i.parameter)];
            add_to(key, context.images[static_cast<std::size_t>(number)]);
        }
        sees_camera |= reads_camera(op) || (is_shiftable(op) && i.mode >= kShift);
    }
    if (sees_camera) {
        key.add(context.camera_from_world).add(std::span(context.viewplane)).add(context.orthographic);
        key.add(context.pixel_width);
    }
}

void add_to(PartKey& key, const ShadingPoint& place) {
    key.add(place.instance != nullptr).add(place.mesh != nullptr);
    if (place.instance != nullptr) {
        const Instance& i = *place.instance;
        key.add(i.world_from_object).add(i.object_from_world).add(i.motion.steps().size());
        for (const Transform& step : i.motion.steps())
            key.add(step);
        key.add(i.random).add(std::span(i.color)).add(i.pass_index).add(std::span(i.properties));
    }
    if (place.mesh != nullptr) {
        const Mesh& m = *place.mesh;
        key.add(m.generated_min).add(m.generated_size).add(m.positions).add(m.triangles);
        key.add(m.uvs.size());
        for (const Buffer<float>& layer : m.uvs)
            key.add(layer);
        key.add(m.attributes.size());
        for (const Buffer<float>& layer : m.attributes)
            key.add(layer);
    }
}

void add_to(PartKey& key, const BoundsFrame& frame, const BoundsOptions& options) {
    key.add(frame.index_from_world).add(frame.world_from_index);
    key.add(std::span(frame.box.min)).add(std::span(frame.box.max));
    key.add(options.accelerator).add(options.minorants);
}

}  // namespace nephele
