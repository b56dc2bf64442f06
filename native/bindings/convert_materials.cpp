// SPDX-License-Identifier: GPL-3.0-or-later
// Shading programs and volume closures.
#include "bindings/attributes.h"
#include "bindings/convert.h"

namespace nephele::bindings {

namespace {

ClosureRow closure_row(nb::handle c) {
    const std::string kind = text(c, "kind");
    const auto* end = kClosureNames + kClosureKindCount;
    const auto* found = std::find(kClosureNames, end, kind);
    if (found == end)
        throw std::invalid_argument("closure '" + kind + "' is not known");
    ClosureRow row;
    row.kind = static_cast<ClosureKind>(found - kClosureNames);
    row.weight = value<std::int16_t>(c, "weight");
    row.mode = value<std::int16_t>(c, "mode");
    const nb::object inputs = c.attr("inputs");
    if (nb::len(inputs) != static_cast<std::size_t>(kClosureInputCounts[found - kClosureNames])) {
        throw std::invalid_argument("closure '" + kind + "' has the wrong number of inputs");
    }
    std::size_t i = 0;
    for (nb::handle input : inputs)
        row.inputs[i++] = nb::cast<std::int16_t>(input);
    return row;
}

}  // namespace

std::optional<Program> program_of(nb::handle p) {
    if (p.is_none())
        return std::nullopt;
    Program out;
    const Buffer<float> registers = floats(p, "registers");
    for (std::size_t i = 0; i + 2 < registers.size(); i += 3) {
        out.registers.emplace_back(registers[i], registers[i + 1], registers[i + 2]);
    }
    const Buffer<std::int32_t> code = integers(p, "code");
    if (code.size() % 8 != 0)
        throw std::invalid_argument("a program's code must have 8 columns");
    for (std::size_t i = 0; i < code.size(); i += 8) {
        out.code.push_back({code[i], code[i + 1], code[i + 2], code[i + 3], code[i + 4], code[i + 5],
                            code[i + 6], code[i + 7]});
    }
    const Buffer<float> parameters = floats(p, "parameters");
    out.parameters.assign(parameters.begin(), parameters.end());
    out.closures = list<ClosureRow>(p, "closures", closure_row);
    return out;
}

namespace {

PhaseFunction phase_function(nb::handle p) {
    const std::string kind = text(p, "kind");
    const auto* end = kPhaseKindNames + kPhaseKindCount;
    const auto* found = std::find(kPhaseKindNames, end, kind);
    if (found == end)
        throw std::invalid_argument("phase function '" + kind + "' is not known");
    const float a = value<float>(p, "a"), b = value<float>(p, "b");
    if (!std::isfinite(a) || !std::isfinite(b))
        throw std::invalid_argument("a parameter of phase function '" + kind + "' is not finite");
    return make_phase(static_cast<PhaseKind>(found - kPhaseKindNames), a, b);
}

VolumeClosure volume_closure(nb::handle c) {
    const auto grid = [&](const char* attribute) {
        const nb::object name = c.attr(attribute);
        return name.is_none() ? std::string() : nb::cast<std::string>(name);
    };
    VolumeClosure out{rgb(c, "sigma_s"),
                      rgb(c, "sigma_a"),
                      rgb(c, "emission"),
                      phase_function(c.attr("phase")),
                      grid("density_grid"),
                      grid("emission_grid"),
                      program_of(c.attr("program")),
                      {}};
    for (nb::handle name : nb::borrow<nb::object>(c.attr("grids")))
        out.grids.push_back(nb::cast<std::string>(name));
    return out;
}

}  // namespace

/// The closures of a volume; one whose sigma and emission are scaled differently becomes two.
std::vector<VolumeClosure> volume_closures_of(nb::handle object) {
    std::vector<VolumeClosure> out;
    for (VolumeClosure& c : list<VolumeClosure>(object, "volume", volume_closure)) {
        if (c.program) {
            out.push_back(std::move(c));
            continue;
        }
        const bool emits = !is_zero(c.emission), extinguishes = !is_zero(c.sigma_s) || !is_zero(c.sigma_a);
        if (emits && extinguishes && !(c.density_grid.empty() && c.emission_grid.empty())) {
            out.push_back({{}, {}, c.emission, c.phase, {}, c.emission_grid, {}, {}});
            c.emission = {};
        }
        if (is_zero(c.emission)) {
            c.emission_grid.clear();
        } else {
            c.density_grid.clear();
        }
        out.push_back(std::move(c));
    }
    return out;
}

}  // namespace nephele::bindings
